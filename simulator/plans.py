"""What vehicles do all day: what a mission asks for at every beat of the vehicle's controller, and by which law.

Heading control is a PD law, in every second mission with an integral part; rate control is a PI law; a pilot moves the
stick and looks at nothing. What is commanded at a beat holds until the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from simulator.vehicles import NAMES, YAW, Vehicle

DAMPING_RATIO = 0.9
"""Damping ratio of a well-tuned heading control."""
STICK = 0.05
"""Step of a pilot's stick, in full torques."""
NEAR = 0.3
"""The integral of a heading control stands still while the heading is off by more [rad]: it is for what lasts."""
SETTLED = 0.2
"""A correction out of the dead band ends when so much of the band is left."""


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
        others: efforts of the other axes, one value a beat [N], [N m]; they look at nothing.
    """

    law: Literal["heading", "rate", "torque"]
    wish: Array
    proportional: float = 0.0
    derivative: float = 0.0
    integral: float = 0.0
    dead_band: float = 0.0
    ahead: Array | None = None
    others: Mapping[str, Array] | None = None


Pilot = Callable[[int, float, float], list[float]]
"""(beat, yaw rate as last seen [rad/s], heading as last seen [rad], counted on) → efforts of the six axes."""


def pilot(plan: Plan, vehicle: Vehicle, period: float) -> Pilot:
    """The controller of a plan, with its memory: the integral, and whether a correction is going on.

    Args:
        plan: what is asked for.
        vehicle: whose largest efforts are the limits.
        period: of its beats [s].
    """
    limit = vehicle.torque
    wish: list[float] = plan.wish.tolist()
    ahead = None if plan.ahead is None else plan.ahead.tolist()
    others = [(NAMES.index(name), values.tolist()) for name, values in (plan.others or {}).items()]
    integral, correcting = 0.0, plan.dead_band == 0.0

    def torque(beat: int, rate: float, heading: float) -> float:
        nonlocal integral, correcting
        if plan.law == "torque":
            return wish[beat]
        error = wish[beat] - (heading if plan.law == "heading" else rate)
        if plan.dead_band:
            correcting = abs(error) > plan.dead_band * (SETTLED if correcting else 1.0)
            if not correcting:
                return 0.0
        asked = plan.proportional * error - plan.derivative * rate + integral + (ahead[beat] if ahead else 0.0)
        limited = min(max(asked, -limit), limit)
        if asked == limited and (plan.law == "rate" or abs(error) < NEAR):
            integral += plan.integral * error * period
        return limited

    def steer(beat: int, rate: float, heading: float) -> list[float]:
        asked = [0.0] * 6
        asked[YAW] = torque(beat, rate, heading)
        for place, values in others:
            asked[place] = values[beat]
        return asked

    return steer


def plan(kind: str, vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """The plan of a mission.

    Args:
        kind: one of PLANS.
        vehicle: for whose size it is made; what else drives it runs at half its largest effort along surge.
        time: (beats,) of the controller [s].
        random: draws courses, lengths and gains.

    Raises:
        KeyError: no such kind.
    """
    if kind in OPEN_LOOP:
        found = Plan("torque", vehicle.torque * OPEN_LOOP[kind](time / vehicle.time, random))
    else:
        found = PLANS[kind](vehicle, time, random)
    if found.others is None and "surge" in vehicle.effort:
        found = replace(found, others={"surge": np.full(time.size, 0.5 * vehicle.effort["surge"])})
    return found


def _spells(time: Array, shortest: float, longest: float, random: np.random.Generator) -> NDArray[np.intp]:
    """(beats,) in which spell each beat lies; a spell lasts between the shortest and the longest."""
    ends = np.cumsum(random.uniform(shortest, longest, int(time[-1] / shortest) + 2))
    return np.searchsorted(ends, time, side="right")


def _signs(count: int, random: np.random.Generator) -> Array:
    return random.choice([-1.0, 1.0], count)


def _heading_control(
    vehicle: Vehicle, wish: Array, random: np.random.Generator, integrates: bool = True, dead_band: float = 0.0
) -> Plan:
    inertia, bandwidth = vehicle.inertia, vehicle.bandwidth * random.uniform(0.85, 1.15)
    proportional = inertia * bandwidth**2
    derivative = max(2.0 * DAMPING_RATIO * inertia * bandwidth - vehicle.linear_drag, 0.0)
    integral = 0.1 * bandwidth * proportional if integrates and random.random() < 0.5 else 0.0
    return Plan("heading", wish, proportional, derivative, integral, dead_band)


def survey(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Legs of two minutes to and fro, with a turn of 180° to starboard, the next to port."""
    leg = _spells(time, 110.0, 130.0, random)
    return _heading_control(vehicle, np.where(leg % 2 == 1, _signs(1, random)[0] * math.pi, 0.0), random)


def _turns(
    shortest: float, longest: float, least: float, most: float
) -> Callable[[Vehicle, Array, np.random.Generator], Plan]:
    """A heading control whose course changes by so much [°] after so long [s]."""

    def make(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
        leg = _spells(time, shortest, longest, random)
        count = int(leg[-1]) + 1
        changes = np.radians(random.uniform(least, most, count)) * _signs(count, random)
        return _heading_control(vehicle, np.cumsum(changes)[leg] - changes[0], random)

    return make


def zigzag(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """The zigzag manoeuvre of sea trials: 20° to either side of the course."""
    leg = _spells(time, 15.0, 25.0, random)
    return _heading_control(vehicle, np.radians(20.0) * np.where(leg % 2 == 1, 1.0, -1.0), random)


def circles(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Circles for minutes, now wider, now narrower, to either side: the wished heading moves on evenly."""
    spell = _spells(time, 150.0, 300.0, random)
    count = int(spell[-1]) + 1
    rates = vehicle.rate * random.uniform(0.3, 0.8, count) * _signs(count, random)
    return _heading_control(vehicle, np.concatenate([[0.0], np.cumsum(rates[spell[1:]] * np.diff(time))]), random)


def limit_cycle(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """A heading control with too much integral gain and no derivative: it swings until quadratic drag holds it."""
    course = _turns(100.0, 250.0, 20.0, 60.0)(vehicle, time, random).wish
    square = (vehicle.bandwidth * random.uniform(0.85, 1.15)) ** 2
    # Hurwitz: I s³ + d' s² + K_p s + K_i is unstable beyond K_i = d' K_p / I.
    integral = random.uniform(1.5, 3.0) * vehicle.linear_drag * square
    return Plan("heading", course, vehicle.inertia * square, 0.0, integral)


def station(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Holds one heading, and does nothing while it is nearly right."""
    band = float(np.radians(random.uniform(4.0, 8.0)))
    return _heading_control(vehicle, np.zeros(time.size), random, integrates=False, dead_band=band)


def rate_control(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Set points of the yaw rate, held for ten to forty seconds; every third is zero."""
    spell = _spells(time, 10.0, 40.0, random)
    count = int(spell[-1]) + 1
    rates = vehicle.rate * random.uniform(-0.8, 0.8, count) * (random.random(count) > 1.0 / 3.0)
    bandwidth = vehicle.bandwidth * random.uniform(0.85, 1.15)
    proportional = 2.0 * vehicle.inertia * bandwidth
    return Plan("rate", rates[spell], proportional, 0.0, 0.5 * bandwidth * proportional)


def one_sided(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Open loop, and the torque never changes its side."""
    spell = _spells(time, 10.0, 60.0, random)
    levels = _on_the_stick(random.uniform(0.05, 0.9, int(spell[-1]) + 1)) * _signs(1, random)
    return Plan("torque", vehicle.torque * levels[spell])


def bursts(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """A pilot's bursts of a few seconds, with pauses between them."""
    count = int(time[-1] / 3.0) + 2
    pauses, bursts = random.uniform(2.0, 30.0, count), random.uniform(1.0, 6.0, count)
    spell = np.searchsorted(np.cumsum(np.column_stack([pauses, bursts]).ravel()), time, side="right")
    levels = np.zeros(2 * count + 1)
    levels[1:-1:2] = _on_the_stick(random.uniform(0.2, 0.9, count)) * _signs(count, random)
    return Plan("torque", vehicle.torque * levels[spell])


def pipeline(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Along a pipeline that winds: the wished heading never rests and never jumps."""
    periods, phases = random.uniform(25.0, 90.0, 4), random.uniform(0.0, 2.0 * math.pi, 4)
    swings = np.sin(2.0 * math.pi * time[:, None] / periods + phases).sum(axis=1)
    return _heading_control(vehicle, np.radians(15.0) * swings, random)


def carried(_vehicle: Vehicle, time: Array, _random: np.random.Generator) -> Plan:
    """Switched on and carried by the water: nothing is asked for."""
    return Plan("torque", np.zeros(time.size), others={})


def holds(vehicle: Vehicle, time: Array, random: np.random.Generator) -> Plan:
    """Every driven axis at levels of its own, each of which holds for a while."""
    asked = {}
    for name, largest in vehicle.effort.items():
        spell = _spells(time, *vehicle.hold_s, random)
        asked[name] = random.uniform(-largest, largest, int(spell[-1]) + 1)[spell]
    yaw = asked.pop("yaw", np.zeros(time.size))
    return Plan("torque", yaw, others=asked)


def _on_the_stick(levels: Array) -> Array:
    return np.asarray(np.maximum(np.round(levels / STICK), 1.0) * STICK)


PLANS: dict[str, Callable[[Vehicle, Array, np.random.Generator], Plan]] = {
    "transit": _turns(120.0, 300.0, 10.0, 10.0),
    "waypoints": _turns(20.0, 60.0, 30.0, 90.0),
} | {
    each.__name__: each
    for each in (
        survey, zigzag, circles, limit_cycle, rate_control, one_sided, bursts, station, pipeline, carried, holds,
    )
}  # fmt: skip
"""Missions: what vehicles do all day."""


def sine(time: Array, random: np.random.Generator) -> Array:
    """One sine, near full torque."""
    period, phase = random.uniform(15.0, 40.0), random.uniform(0.0, 2.0 * math.pi)
    return np.asarray(random.uniform(0.9, 1.0) * np.sin(2.0 * math.pi * time / period + phase))


def multisine(time: Array, random: np.random.Generator) -> Array:
    """Five to nine sines over a decade of periods, peak near full torque."""
    count = int(random.integers(5, 10))
    periods = np.geomspace(6.0, 60.0, count) * random.uniform(0.9, 1.1, count)
    phases = random.uniform(0.0, 2.0 * math.pi, count)
    total = (np.sqrt(periods) * np.sin(2.0 * math.pi * time[:, None] / periods + phases)).sum(axis=1)
    return np.asarray(random.uniform(0.9, 1.0) * total / np.max(np.abs(total)))


def telegraph(time: Array, random: np.random.Generator) -> Array:
    """Random times at one of a few levels of either sign."""
    spell = _spells(time, 2.0, 14.0, random)
    levels = np.array([-1.0, -0.55, 0.55, 1.0]) * random.uniform(0.9, 1.0)
    return np.asarray(random.choice(levels, size=int(spell[-1]) + 1)[spell])


def steps(time: Array, random: np.random.Generator) -> Array:
    """A staircase through random levels, each of which holds until the rate has settled."""
    spell = _spells(time, 10.0, 30.0, random)
    return np.asarray(random.uniform(-1.0, 1.0, size=int(spell[-1]) + 1)[spell])


def prbs(time: Array, random: np.random.Generator) -> Array:
    """A pseudo-random binary sequence of a nine-bit shift register, of another amplitude every quarter of the run."""
    register, clock = int(random.integers(1, 512)), random.uniform(0.6, 1.1)
    bits = np.empty(int(time[-1] / clock) + 1)
    for k in range(bits.size):
        bits[k] = 1.0 if register & 1 else -1.0
        register = register >> 1 | ((register ^ register >> 4) & 1) << 8
    quarter = np.minimum(4.0 * time / (time[-1] + 1.0), 3.0).astype(int)
    return np.asarray(bits[(time / clock).astype(int)] * random.permutation([0.1, 0.35, 0.65, 0.95])[quarter])


def ramps(time: Array, random: np.random.Generator) -> Array:
    """Lines from one level to the next, now flat, now steep; the sides alternate."""
    corners = np.concatenate([[0.0], np.cumsum(random.uniform(1.0, 5.0, int(time[-1]) + 2))])
    sides = np.where(np.arange(corners.size) % 2, 1.0, -1.0)
    return np.interp(time, corners, sides * random.uniform(0.2, 1.0, corners.size))


def stairs(time: Array, random: np.random.Generator) -> Array:
    """Up and down a stair of torques, lower about zero, with treads long enough to come near the steady rate."""
    treads = int(random.integers(4, 7))
    even = np.linspace(-1.0, 1.0, 2 * treads + 1)
    levels = np.copysign(np.abs(even) ** 1.5, even)
    cycle = np.concatenate([levels[treads:], levels[-2::-1], levels[1:treads]])
    spell = _spells(time, 1.2, 3.0, random)
    return np.asarray(cycle[spell % cycle.size] * random.uniform(0.8, 1.0))


OPEN_LOOP: dict[str, Callable[[Array, np.random.Generator], Array]] = {
    each.__name__: each for each in (sine, multisine, telegraph, steps, prbs, ramps, stairs)
}
"""Excitation in open loop: (time in the vehicle's I r/τ, chance) → parts of the full torque."""
