"""The values of a configuration that are scaled to recordings, to the digits that are written down."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from incsvr.learning.learner import Settings
from incsvr.signals import SignalSettings
from service.cli.output import writing
from service.config.config_writer import commented_yaml
from service.config.configuration import Config
from service.recordings.recording import Recording

LIMIT_MARGIN = 2.0
"""A torque or a yaw rate beyond so many times the recordings' largest is written down as no measurement."""
MARK = "# What is left out is as `incsvr config show` prints it"
"""The words by which a file that was written here is recognised."""
AnySettings = TypeVar("AnySettings", SignalSettings, Settings)
MAX_RATE_LIMIT = 50.0
"""The largest rate limit that the configuration takes [rad/s]."""


def scaled_config(base: Config, recording: Recording, signals: SignalSettings, learner: Settings) -> Config:
    """`base` with the vehicle, the signals and the learner that suit a recording, to three digits."""
    low, high = (_three(end) for end in learner.rate_range)
    torque = float(np.nanmax(np.abs(recording.effort)))
    vehicle = base.vehicle.model_dump() | {
        "inertia": signals.inertia,
        "rate_range": (low, high),
        "rate_limit": min(float(f"{LIMIT_MARGIN * high:.2g}"), MAX_RATE_LIMIT),
        "torque_limit": float(f"{LIMIT_MARGIN * torque:.2g}"),
    }
    if base.vehicle.mass_matrix is not None:
        del vehicle["inertia"]  # it follows from the matrix
    # Lateness and gap suit a file; on the bus the defaults do. What the torque is here it is there.
    return Config.model_validate(
        base.model_dump()
        | {
            "vehicle": vehicle,
            "signals": base.signals.model_dump()
            | _fields(signals, ("sample_period", "smoothing", "channels", "torque")),
            "learner": base.learner.model_dump()
            | _fields(learner, type(base.learner).model_fields.keys() - {"fastest"}),
        }
    )


def write(path: Path, config: Config, head: str) -> None:
    """Writes what of a configuration is not as it is by default, each value with its meaning, below lines of `head`.

    Raises:
        BadInput: it cannot be written.
    """
    rest = f"{MARK}; `incsvr config check FILE` says what is wrong.\n"
    with writing(path, "--write"):
        path.write_text(commented_yaml(config, head + rest, brief=True), encoding="utf-8")


def three_digits(settings: AnySettings) -> AnySettings:
    """Settings that were scaled to recordings, as `scaled_config` writes them."""
    names = ("sample_period", "smoothing", "gamma", "C", "epsilon", "near_rate", "near_damping", "rate_range")
    return replace(settings, **_fields(settings, names))


def _fields(settings: SignalSettings | Settings, names: Iterable[str]) -> dict[str, Any]:
    values = asdict(settings)
    return {name: _three(values[name]) for name in names if name in values}


def _three(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_three(each) for each in value)
    return float(f"{value:.3g}") if isinstance(value, float) else value
