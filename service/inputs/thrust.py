"""Static thrust: what a thruster pushes at rest by what it is told, before the water and the rotor have their say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.settings import Axis, Thrusters
from service.inputs.units import FACTORS, KGF_N

NEUTRAL_PULSE_US = 1500.0
"""Pulse at which a thruster rests [µs]."""
FULL_PULSE_US = 400.0
"""The pulse at full thrust from the neutral one [µs]."""
PULSE_RANGE_US = (800.0, 2200.0)
"""The shortest and the longest pulse [µs], for ArduPilot's outputs are set within these: beyond, the output is off. 0
says so, and 65535 that there is no such output."""

T200_VOLTAGES_V = (10.0, 12.0, 14.0, 16.0, 18.0, 20.0)
T200_FORWARD_KGF = (2.93, 3.71, 4.53, 5.25, 6.02, 6.72)
T200_REVERSE_KGF = (2.31, 2.92, 3.52, 4.07, 4.59, 5.04)
"""Thrust at 1900 and at 1100 µs by the voltage, from the maker's data of September 2019 [kgf]; those of 10 V follow the
others' trend."""
T200_DEAD_BAND_US = (38.0, 36.0, 32.0, 28.0, 28.0, 26.0)
"""Half width of the dead band by the voltage, from the same data [µs]."""
T200_EXPONENT = 1.3
"""The power of the command that the curve is between the band's edge and full thrust: at 12 V within 2 % of full thrust
of a cubic that others fitted to the maker's data, at 16 V within 2 % of full thrust forward and 6 % reverse of a
measured vehicle's table."""
T200_NOMINAL_V = 16.0
"""The voltage of a charged battery of four cells [V], where nobody knows better."""


def t200(pulse: Array, volts: Array) -> Array:
    """Thrust of a Blue Robotics T200 at rest [N].

    Args:
        pulse: (…, n) from neutral, positive forward [µs].
        volts: (n,) of the battery, within 10 to 20 [V]; beyond, those at the end.
    """
    full = np.where(
        pulse >= 0.0,
        np.interp(volts, T200_VOLTAGES_V, T200_FORWARD_KGF),
        np.interp(volts, T200_VOLTAGES_V, T200_REVERSE_KGF),
    )
    band = np.interp(volts, T200_VOLTAGES_V, T200_DEAD_BAND_US)
    part = np.clip((np.abs(pulse) - band) / (FULL_PULSE_US - band), 0.0, 1.0)
    thrust: Array = np.sign(pulse) * KGF_N * full * part**T200_EXPONENT
    return thrust


def is_pulse(command: Any) -> Any:
    """Whether a command [µs], or which of (n,), is a pulse at all: an output without one gives no thrust."""
    return (command >= PULSE_RANGE_US[0]) & (command <= PULSE_RANGE_US[1])


def is_battery_voltage(volts: Array) -> NDArray[np.bool_]:
    """Selects the values (n,) that are a battery's voltage: without a monitor they are 0 or 65.5 V."""
    return (volts > 6.0) & (volts < 26.0)


def efforts(
    settings: Thrusters,
    axes: Sequence[Axis],
    commands: Sequence[Array],
    volts: Array,
    speed: Array,
    angles: Mapping[int, Array],
) -> Array:
    """Moments of all thrusters about each of the axes, or forces along it, (axes, n) [N m], [N].

    Args:
        commands: (n,) of each thruster, as it is told.
        volts: (n,) of the battery [V].
        speed: (n,) of the vehicle along its bow [m/s].
        angles: (n,) by which those that can be turned are, by their number [rad].
    """
    forward = [
        command if each.direction > 0 else _reversed_command(settings, command)
        for each, command in zip(settings.each, commands, strict=True)
    ]
    straight, push = np.zeros(volts.size), thrust(settings, np.stack(forward), volts, speed)
    totals = []
    for axis in axes:
        shares = [each.share(axis, angles.get(k, straight)) for k, each in enumerate(settings.each)]
        totals.append((np.stack(shares) * push).sum(axis=0))
    return settings.scale * np.stack(totals)


def _reversed_command(settings: Thrusters, command: Array) -> Array:
    """The command of a thruster that counts in the other direction."""
    if settings.command == "pwm":
        return np.where(is_pulse(command), 2.0 * NEUTRAL_PULSE_US - command, command)
    return -command


def thrust(settings: Thrusters, command: Array, volts: Array, speed: Array) -> Array:
    """Thrust at rest [N] by commands (…, n) in their unit that are positive forward.

    Args:
        volts: (n,) of the battery [V].
        speed: (n,) of the vehicle along its bow [m/s].
    """
    told = settings.command
    if told == "N":
        return command
    if told == "pwm":
        pulse = np.where(
            is_pulse(command), command - NEUTRAL_PULSE_US, 0.0 * command
        )  # where there is no number, NaN stays
        return pulse_thrust(settings, pulse, volts)
    if told == "fraction":
        return pulse_thrust(settings, FULL_PULSE_US * command, volts)
    speed_of_rotor = command * (FACTORS["rpm"] if told == "rpm" else 1.0)
    if isinstance(settings.curve, Path):
        return _thrust_from_table(settings.curve, command)
    wash = settings.inflow * speed * np.abs(speed_of_rotor)
    return np.asarray(settings.full * speed_of_rotor * np.abs(speed_of_rotor) + wash)


def pulse_thrust(settings: Thrusters, pulse: Array, volts: Array) -> Array:
    """Thrust [N] by pulses from neutral (…, n) [µs]."""
    if isinstance(settings.curve, Path):
        return _thrust_from_table(
            settings.curve, pulse + NEUTRAL_PULSE_US if settings.command == "pwm" else pulse / FULL_PULSE_US
        )
    if settings.curve == "t200":
        return t200(pulse, volts)
    part = np.clip(pulse / FULL_PULSE_US, -1.0, 1.0)
    return np.asarray(settings.full * (part * np.abs(part) if settings.curve == "quadratic" else part))


def _thrust_from_table(path: Path, command: Array) -> Array:
    """The thrust by a file with two columns, command and thrust [N], the first rising."""
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as error:
        raise BadInput(
            f"{path}: cannot be read as a thrust curve ({error}); write command,newtons in each row"
        ) from None
    if table.shape[1] != 2 or not (np.diff(table[:, 0]) > 0.0).all():
        raise BadInput(f"{path}: a thrust curve has two columns, command and thrust [N], and rises in the first")
    return np.interp(command, table[:, 0], table[:, 1])
