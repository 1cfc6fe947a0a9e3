"""Samples as plain data for a file, exact to the bit through JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from incsvr.signals.samples import Samples


def columns_to_dict(samples: Samples) -> dict[str, Any]:
    """The time [s], own velocity [rad/s] and damping [N m] of samples."""
    return {
        "time": samples.time.tolist(),
        "yaw_rate": samples.yaw_rate.tolist(),
        "damping": samples.damping.tolist(),
    }


def others_to_dict(samples: Samples) -> dict[str, Any]:
    """The further velocities of samples; nothing where they have none."""
    return {"others": {name: values.tolist() for name, values in samples.channels.items()}} if samples.channels else {}


def samples_from_dict(data: Mapping[str, Any]) -> Samples:
    """The samples of `columns_to_dict` and `others_to_dict`."""
    time, rate, damping = (np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping"))
    others = {name: np.array(values, dtype=np.float64) for name, values in data.get("others", {}).items()}
    return Samples(time, rate, damping, others)
