"""Samples as plain data, exact to the bit through JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.samples import Samples


def plain_samples(samples: Samples) -> dict[str, Any]:
    """Samples as the durable state keeps them; `samples_of` makes the same of it."""
    return {
        "time": samples.time.tolist(),
        "yaw_rate": samples.yaw_rate.tolist(),
        "damping": samples.damping.tolist(),
        "channels": {name: json_values(values) for name, values in samples.channels.items()},
        "parts": {name: values.tolist() for name, values in samples.parts.items()},
        "raw": {name: json_values(values) for name, values in samples.raw.items()},
    }


def json_values(values: Array) -> tuple[float | None, ...]:
    """A channel's values as JSON knows them: None where it was not sampled, or filtered beyond all floats."""
    return tuple(value if math.isfinite(value) else None for value in values.tolist())


def samples_of(plain: Mapping[str, Any]) -> Samples:
    """The samples whose `plain_samples` gave this."""
    return Samples(
        np.array(plain["time"], dtype=np.float64),
        np.array(plain["yaw_rate"], dtype=np.float64),
        np.array(plain["damping"], dtype=np.float64),
        *(
            {name: np.array(values, dtype=np.float64) for name, values in plain.get(kind, {}).items()}
            for kind in ("channels", "parts", "raw")
        ),
    )
