"""The torque of thrusters, message by message: what each was told last becomes the moment of all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isnan, nan

import numpy as np

from service.inputs.forms import number
from service.inputs.known import SURGE, VOLTAGE, Known
from service.inputs.resolving import ANGLE
from service.inputs.settings import Thrusters
from service.inputs.thrust import T200_NOMINAL, moment, sensible

SOON = 50
"""Commands until which the battery's voltage may come: it is told every few seconds."""


@dataclass(slots=True)
class ToldTorque:
    """What the thrusters were told.

    Attributes:
        count: moments that were told.
    """

    count: int = 0
    _commands: list[float] = field(default_factory=list)
    _waiting: tuple[float, float] | None = None

    def take(self, settings: Thrusters, known: Known) -> bool:
        """Takes the commands of a message; False where one of them is missing in it."""
        if len(self._commands) != len(settings.each):
            self._commands = [nan] * len(settings.each)
        for each in known.commands:
            command = number(known.message, settings.each[each].field)
            if command is None:
                return False
            self._commands[each] = command
        return True

    def told(
        self, settings: Thrusters, known: Known, t: float, latest: Mapping[str, float]
    ) -> tuple[float, float] | None:
        """Stamp [s] and moment [N m], once every thruster has told its command and every angle is known.

        Where each has a key of its own, it waits for a later stamp: what bears the same belongs to the same moment.

        Args:
            latest: voltage [V], surge [m/s] and angles [rad], as far as they are known.
        """
        turned = [k for k, each in enumerate(settings.each) if each.turned_by is not None]
        if any(map(isnan, self._commands)) or any(ANGLE.format(k) not in latest for k in turned):
            return None
        volts = measured(latest)
        if volts is None:
            volts = T200_NOMINAL if settings.voltage is None else settings.voltage
        commands = [np.array([command]) for command in self._commands]
        angles = {k: np.array([latest[ANGLE.format(k)]]) for k in turned}
        with np.errstate(all="ignore"):  # what is no command makes no moment, and is refused as beyond the plausible
            total = moment(settings, commands, np.array([volts]), np.array([latest.get(SURGE, 0.0)]), angles)
        now = (t, float(total[0]))
        if len(known.commands) < len(settings.each):
            before, self._waiting = self._waiting, now
            if before is None or before[0] >= t:
                return None
            now = before
        self.count += 1
        return now

    def guessed_voltage(self, settings: Thrusters, latest: Mapping[str, float]) -> bool:
        """Whether the thrust is that of a voltage that nobody told, though it had time to come."""
        by_voltage = settings.curve == "t200" and settings.command in ("pwm", "fraction")
        return by_voltage and settings.voltage is None and self.count > SOON and measured(latest) is None


def measured(latest: Mapping[str, float]) -> float | None:
    """The battery's voltage [V], where something tells one that a battery can have."""
    volts = latest.get(VOLTAGE)
    return volts if volts is not None and sensible(np.array([volts]))[0] else None
