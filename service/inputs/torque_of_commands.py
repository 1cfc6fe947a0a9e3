"""The torque of thrusters, message by message: what each was told last becomes the moment of all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isnan, nan

import numpy as np

from service.inputs.forms import number
from service.inputs.key_resolution import ANGLE_NAME, BATTERY_NAME
from service.inputs.outputs import Movement, least_movement, output_numbers, without_pulse
from service.inputs.settings import Axis, Thrusters
from service.inputs.source_binding import SURGE, VOLTAGE, SourceBinding
from service.inputs.thrust import T200_NOMINAL_V, efforts, is_battery_voltage, is_pulse

GRACE_MESSAGES = 50
"""Messages until which the battery's voltage and the first pulse may come: a voltage is told every few seconds."""


@dataclass(slots=True)
class TorqueOfCommands:
    """The torque of the thrusters' commands.

    Attributes:
        count: moments that were told.
        movement: whether one of the commands has moved.
    """

    count: int = 0
    movement: Movement = field(default_factory=Movement)
    _messages: int = 0
    _commands: list[float] = field(default_factory=list)
    _pulsed: set[tuple[str, str]] = field(default_factory=set)
    _waiting: tuple[float, list[float]] | None = None

    def take(self, settings: Thrusters, known: SourceBinding) -> bool:
        """Takes the commands of a message; False where one of them is missing in it."""
        if len(self._commands) != len(settings.each):
            self._commands = [nan] * len(settings.each)
        self._messages += 1
        taken: dict[str, float | None] = {}
        for each in known.commands:
            path = settings.each[each].field
            command = taken[str(each)] = number(known.message, path)
            if command is not None:
                self._commands[each] = command
                if settings.command != "pwm" or is_pulse(command):
                    self._pulsed.add((settings.topics[each], path))
            elif output_numbers(settings)[each] is None:
                return False
        self.movement.take(taken, least_movement(settings))
        return True

    def silent(self, settings: Thrusters) -> str | None:
        """The sentence on thrusters that have had no pulse so far; None if all have."""
        waiting = self._without(settings)
        return without_pulse(settings, waiting) if waiting and self._messages > GRACE_MESSAGES else None

    def _without(self, settings: Thrusters) -> list[int]:
        """Thrusters that have not got a pulse, or another command, yet: before that they tell nothing."""
        places = zip(settings.topics, (each.field for each in settings.each), strict=True)
        return [k for k, place in enumerate(places) if place not in self._pulsed]

    def newest_efforts(
        self,
        settings: Thrusters,
        known: SourceBinding,
        t: float,
        latest: Mapping[str, float],
        further: tuple[Axis, ...] = (),
    ) -> tuple[float, list[float]] | None:
        """Stamp [s] and efforts [N m], [N], once every thruster has told its command and every angle is known: of the
        settings' axis, then of the further ones.

        Where each has a key of its own, it waits for a later stamp: what bears the same belongs to the same moment.

        Args:
            latest: voltage [V], surge [m/s] and angles [rad], as far as they are known.
        """
        turned = [k for k, each in enumerate(settings.each) if each.turned_by is not None]
        if (
            any(map(isnan, self._commands))
            or self._without(settings)
            or any(ANGLE_NAME.format(k) not in latest for k in turned)
        ):
            return None
        volts = battery_voltage(latest)
        if volts is None:
            volts = T200_NOMINAL_V if settings.voltage is None else settings.voltage
        commands = [np.array([command]) for command in self._commands]
        angles = {k: np.array([latest[ANGLE_NAME.format(k)]]) for k in turned}
        with np.errstate(all="ignore"):  # what is no command makes no moment, and is refused as beyond the plausible
            axes, speed = (settings.axis, *further), np.array([latest.get(SURGE, 0.0)])
            totals = efforts(settings, axes, commands, np.array([volts]), speed, angles)
        now = (t, totals[:, 0].tolist())
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
        return (
            by_voltage and settings.voltage is None and self.count > GRACE_MESSAGES and battery_voltage(latest) is None
        )


def battery_voltage(latest: Mapping[str, float]) -> float | None:
    """The battery's voltage [V], where something tells one that a battery can have."""
    volts = latest.get(BATTERY_NAME, latest.get(VOLTAGE))
    return volts if volts is not None and is_battery_voltage(np.array([volts]))[0] else None
