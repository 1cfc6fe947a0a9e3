"""What vehicles do all day: what a mission asks for at every beat of the vehicle's controller, and by which law.

Heading control is a PD law, in every second mission with an integral part; rate control is a PI law; a pilot moves the
stick in steps and looks at nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from simulator.missions.vehicles import Vehicle
from simulator.trial_effects.physics import Array

DAMPING_RATIO = 0.9
"""Damping ratio of a well-tuned heading control."""
STICK = 0.05
"""Step of a pilot's stick, in full torques."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is asked for, and the law that makes a torque of it.

    Attributes:
        law: what the wish is: a heading, a yaw rate or the torque itself.
        wish: one value a beat [rad], [rad/s] or [N m].
        proportional: [N m/rad], or [N m s/rad] of a rate control.
        derivative: torque against the gyro's rate [N m s/rad], of a heading control.
        integral: [N m/(rad s)], or [N m/rad] of a rate control.
        dead_band: the heading may be off by so much before anything is done about it [rad].
        ahead: torque that is added whatever the sensors show, one value a beat [N m]; empty for none.
    """

    law: Literal["heading", "rate", "torque"]
    wish: list[float]
    proportional: float = 0.0
    derivative: float = 0.0
    integral: float = 0.0
    dead_band: float = 0.0
    ahead: Sequence[float] = ()


def plan(kind: str, vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """The plan of a mission.

    Args:
        kind: one of PLANS.
        vehicle: for whose size it is made.
        time: (beats,) of the controller [s].
        random: draws courses, lengths and gains.

    Raises:
        KeyError: no such kind.
    """
    return PLANS[kind](vehicle, time, random)


def _spells(time: Array, shortest: float, longest: float, random: np.random.Generator) -> NDArray[np.intp]:
    """(beats,) in which spell each beat lies; a spell lasts between the shortest and the longest [s]."""
    ends = np.cumsum(random.uniform(shortest, longest, int(time[-1] / shortest) + 2))
    return np.searchsorted(ends, time, side="right")


def _signs(count: int, random: np.random.Generator) -> Array:
    return random.choice([-1.0, 1.0], count)


def _heading_control(
    vehicle: Vehicle, wish: Array, random: np.random.Generator, integrates: bool = True, dead_band: float = 0.0
) -> Plan:
    inertia, bandwidth = vehicle.scale.inertia, vehicle.bandwidth * random.uniform(0.85, 1.15)
    proportional = inertia * bandwidth**2
    derivative = max(2.0 * DAMPING_RATIO * inertia * bandwidth - vehicle.linear_drag, 0.0)
    integral = 0.1 * bandwidth * proportional if integrates and random.random() < 0.5 else 0.0
    return Plan("heading", wish.tolist(), proportional, derivative, integral, dead_band)


def _survey(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Legs of two minutes to and fro, with a turn of 180° to starboard, the next to port."""
    leg = _spells(time, 110.0, 130.0, random)
    first = float(_signs(1, random)[0]) * math.pi
    return _heading_control(vehicle, np.where(leg % 2 == 1, first, 0.0), random)


def _transit(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """One course, corrected by 10° every few minutes."""
    leg = _spells(time, 120.0, 300.0, random)
    changes = np.radians(10.0) * _signs(int(leg[-1]) + 1, random)
    changes[0] = 0.0
    return _heading_control(vehicle, np.cumsum(changes)[leg], random)


def _waypoints(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """From waypoint to waypoint: every half minute or so another course, 30 to 90° off."""
    leg = _spells(time, 20.0, 60.0, random)
    count = int(leg[-1]) + 1
    changes = np.radians(random.uniform(30.0, 90.0, count)) * _signs(count, random)
    return _heading_control(vehicle, np.cumsum(changes)[leg], random)


def _zigzag(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """The zigzag manoeuvre of sea trials: 20° to either side of the course."""
    leg = _spells(time, 15.0, 25.0, random)
    return _heading_control(vehicle, np.radians(20.0) * np.where(leg % 2 == 1, 1.0, -1.0), random)


def _circles(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Circles for minutes, now wider, now narrower, to either side: the wished heading moves on evenly."""
    spell = _spells(time, 150.0, 300.0, random)
    count = int(spell[-1]) + 1
    rates = vehicle.scale.rate * random.uniform(0.3, 0.8, count) * _signs(count, random)
    wish = np.concatenate([[0.0], np.cumsum(rates[spell[1:]] * np.diff(time))])
    return _heading_control(vehicle, wish, random)


def _wagging(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """A heading control with too much integral gain and no derivative: it swings until quadratic drag holds it."""
    leg = _spells(time, 100.0, 250.0, random)
    count = int(leg[-1]) + 1
    course = np.cumsum(np.radians(random.uniform(20.0, 60.0, count)) * _signs(count, random))
    square = (vehicle.bandwidth * random.uniform(0.85, 1.15)) ** 2
    # Hurwitz: I s³ + d' s² + K_p s + K_i is unstable beyond K_i = d' K_p / I.
    integral = random.uniform(1.5, 3.0) * vehicle.linear_drag * square
    return Plan("heading", course[leg].tolist(), vehicle.scale.inertia * square, 0.0, integral)


def _station(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Holds one heading, and does nothing while it is nearly right."""
    band = np.radians(random.uniform(4.0, 8.0))
    return _heading_control(vehicle, np.zeros(time.size), random, integrates=False, dead_band=float(band))


def _rate_control(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Set points of the yaw rate, held for ten to forty seconds; every third is zero."""
    spell = _spells(time, 10.0, 40.0, random)
    count = int(spell[-1]) + 1
    rates = vehicle.scale.rate * random.uniform(-0.8, 0.8, count) * (random.random(count) > 1.0 / 3.0)
    bandwidth = vehicle.bandwidth * random.uniform(0.85, 1.15)
    proportional = 2.0 * vehicle.scale.inertia * bandwidth
    return Plan("rate", rates[spell].tolist(), proportional, 0.0, 0.5 * bandwidth * proportional)


def _one_sided(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Open loop, and the torque never changes its side."""
    spell = _spells(time, 10.0, 60.0, random)
    levels = _on_the_stick(random.uniform(0.05, 0.9, int(spell[-1]) + 1)) * _signs(1, random)
    return Plan("torque", (vehicle.scale.torque * levels[spell]).tolist())


def _bursts(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """A pilot's bursts of a few seconds, with pauses between them."""
    count = int(time[-1] / 3.0) + 2
    pauses, bursts = random.uniform(2.0, 30.0, count), random.uniform(1.0, 6.0, count)
    ends = np.cumsum(np.column_stack([pauses, bursts]).ravel())
    spell = np.searchsorted(ends, time, side="right")
    levels = np.zeros(2 * count + 1)
    levels[1:-1:2] = _on_the_stick(random.uniform(0.2, 0.9, count)) * _signs(count, random)
    return Plan("torque", (vehicle.scale.torque * levels[spell]).tolist())


def _pipeline(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Along a pipeline that winds: the wished heading never rests and never jumps."""
    periods = random.uniform(25.0, 90.0, 4)
    phases = random.uniform(0.0, 2.0 * math.pi, 4)
    swings = np.sin(2.0 * math.pi * time[:, None] / periods + phases).sum(axis=1)
    return _heading_control(vehicle, np.radians(15.0) * swings, random)


def _day(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Out to the site, legs to and fro over it, and a heading held for the rest of the time, a third each."""
    out, over = time < time[-1] / 3.0, time < time[-1] * 2.0 / 3.0
    course = _spells(time[out], 120.0, 300.0, random)
    changes = np.radians(10.0) * _signs(int(course[-1]) + 1, random)
    courses = np.cumsum(changes)[course]
    leg = _spells(time[over & ~out] - time[out][-1], 110.0, 130.0, random)
    wish = np.concatenate([courses, courses[-1] + math.pi * (leg % 2), np.full(np.count_nonzero(~over), courses[-1])])
    return _heading_control(vehicle, wish, random)


def _on_deck(_vehicle: Vehicle, time: Array, _random: np.random.Generator) -> Plan:
    """Switched on and carried: nothing is asked for."""
    return Plan("torque", [0.0] * time.size)


def _on_the_stick(levels: Array) -> Array:
    return np.asarray(np.maximum(np.round(levels / STICK), 1.0) * STICK)


PLANS: dict[str, Callable[[Vehicle, Array, np.random.Generator], Plan]] = {
    "survey": _survey,
    "transit": _transit,
    "waypoints": _waypoints,
    "zigzag": _zigzag,
    "circles": _circles,
    "wagging": _wagging,
    "rate_control": _rate_control,
    "one_sided": _one_sided,
    "bursts": _bursts,
    "station": _station,
    "on_deck": _on_deck,
    "pipeline": _pipeline,
    "day": _day,
}
