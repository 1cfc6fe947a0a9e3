"""Whether outputs move: a vehicle whose outputs do is driven, whatever else says so."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite

import numpy as np

from incsvr.numerics import Array
from service.inputs.settings import Thrusters
from service.inputs.thrust import FULL_PULSE_US, T200_DEAD_BAND_US, is_pulse

MIN_PULSE_MOVEMENT_US = max(T200_DEAD_BAND_US)
"""The change beyond which a pulse leaves the dead band of a T200 [µs]; one that trembles at rest does not."""


class Movement:
    """Message by message: whether one of the commands has changed by more than it does at rest."""

    def __init__(self) -> None:
        self.has_moved = False
        self._ends: dict[str, tuple[float, float]] = {}

    def take(self, commands: Mapping[str, float | None], least: float) -> None:
        """Takes the commands of a message by their paths; those that are pulses count where there is a pulse."""
        for path, command in commands.items():
            if command is None or not isfinite(command) or (least == MIN_PULSE_MOVEMENT_US and not is_pulse(command)):
                continue
            low, high = self._ends.get(path, (command, command))
            self._ends[path] = min(low, command), max(high, command)
            self.has_moved = self.has_moved or max(high, command) - min(low, command) > least


def least_movement(settings: Thrusters) -> float:
    """The change of a command that counts as movement, in its unit; only pulses have a known band."""
    return {"pwm": MIN_PULSE_MOVEMENT_US, "fraction": MIN_PULSE_MOVEMENT_US / FULL_PULSE_US}.get(settings.command, 0.0)


def first_movement(commands: Sequence[Array], least: float) -> int | None:
    """The place of the first message by which one of the commands (n,), in their order, has moved; None if none did."""
    moved = np.zeros(commands[0].size if commands else 0, dtype=bool)
    for command in commands:
        known = np.isfinite(command) & (is_pulse(command) if least == MIN_PULSE_MOVEMENT_US else True)
        low = np.minimum.accumulate(np.where(known, command, np.inf))
        high = np.maximum.accumulate(np.where(known, command, -np.inf))
        moved |= high - low > least
    return int(np.argmax(moved)) if moved.any() else None
