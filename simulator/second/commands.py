"""What is asked of the thrusters: five programs in open loop, and two controllers that see what is logged.

A pilot is called once a period of its computer, and what it asks for is held until the next: (tick, yaw rate as last
logged [rad/s], heading as last logged [rad]) -> moment [N m].
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from simulator.second.plant import Array
from simulator.second.vehicles import Vehicle

Pilot = Callable[[int, float, float], float]
Program = Callable[[Array, float, np.random.Generator], Array]
"""(stamps of the ticks [s], the vehicle's time scale [s], chance) -> parts of the full torque at the ticks."""

PERIODS = (0.04, 0.05, 0.08, 0.1, 0.2)
"""Periods of the pilots' computers [s]: 25 to 5 Hz, whole parts of the integration's step."""
MAX_PERIOD_SHARE = 0.25
"""Longest period of a computer, in the vehicle's time scale: a slower one could not hold the vehicle."""
THRUSTER_STEPS = (0, 0, 12, 24, 60)
"""Steps from none to full of the thrusters' command; 0 where the command is as exact as its number."""


def prbs(time: Array, scale: float, random: np.random.Generator) -> Array:
    """A pseudo-random binary sequence of a nine-bit shift register, of another amplitude every quarter of the run."""
    register = int(random.integers(1, 512))
    clock = scale * random.uniform(0.6, 1.1)
    bits = np.empty(int(time[-1] / clock) + 1)
    for k in range(bits.size):
        bits[k] = 1.0 if register & 1 else -1.0
        register = register >> 1 | ((register ^ register >> 4) & 1) << 8
    amplitudes = random.permutation([0.1, 0.35, 0.65, 0.95])
    quarter = np.minimum(4.0 * time / (time[-1] + 1.0), 3.0).astype(int)
    return np.asarray(bits[(time / clock).astype(int)] * amplitudes[quarter])


def bursts(time: Array, scale: float, random: np.random.Generator) -> Array:
    """A joystick: pushed to either side for a while, with a hand's haste, and let go."""
    corners, levels = [0.0], [0.0]
    while corners[-1] < time[-1]:
        rest, haste, pushed = scale * random.uniform([0.3, 0.15, 0.6], [2.5, 0.5, 2.5])
        level = random.choice([-1.0, 1.0]) * random.uniform(0.08, 1.0)
        corners += (corners[-1] + np.cumsum([rest, haste, pushed, haste])).tolist()
        levels += [0.0, level, level * random.uniform(0.8, 1.0), 0.0]
    return np.interp(time, corners, levels)


def ramps(time: Array, scale: float, random: np.random.Generator) -> Array:
    """Lines from one level to the next, now flat, now steep; the sides alternate."""
    corners, levels, side = [0.0], [0.0], 1.0
    while corners[-1] < time[-1]:
        corners.append(corners[-1] + scale * random.uniform(1.0, 5.0))
        levels.append(side * random.uniform(0.2, 1.0))
        side = -side
    return np.interp(time, corners, levels)


def noise_band(time: Array, scale: float, random: np.random.Generator) -> Array:
    """A band of noise: forty lines of even power and random phase, from slow drift to about the vehicle's own band."""
    frequencies = random.uniform(0.015, 0.45, 40) / scale
    phases = random.uniform(0.0, 2.0 * math.pi, 40)
    band = np.zeros(time.size)
    for frequency, phase in zip(frequencies, phases, strict=True):
        band += np.cos(2.0 * math.pi * frequency * time + phase)
    return band * (0.42 / math.sqrt(20.0))


def stairs(time: Array, scale: float, random: np.random.Generator) -> Array:
    """Up and down a stair of torques, lower about zero, with treads long enough to come near the steady rate."""
    treads = int(random.integers(4, 7))
    even = np.linspace(-1.0, 1.0, 2 * treads + 1)
    levels = np.copysign(np.abs(even) ** 1.5, even)
    cycle = np.concatenate([levels[treads:], levels[-2::-1], levels[1:treads]])
    edges, count = [0.0], 0
    while edges[-1] < time[-1]:
        edges.append(edges[-1] + scale * random.uniform(1.2, 3.0))
        count += 1
    heights = np.resize(cycle, count) * random.uniform(0.8, 1.0)
    return np.asarray(heights[np.searchsorted(edges, time, side="right") - 1])


OPEN_LOOP: dict[str, Program] = {
    "prbs": prbs,
    "bursts": bursts,
    "ramps": ramps,
    "noise_band": noise_band,
    "stairs": stairs,
}


def rate_reference(time: Array, vehicle: Vehicle, random: np.random.Generator) -> Array:
    """(ticks,) yaw rates to hold [rad/s]: now one, now another, with swings between."""
    scale, full = vehicle.time_scale, 0.8 * vehicle.full_rate
    corners, levels, level = [0.0], [0.0], 0.0
    while corners[-1] < time[-1]:
        swing, hold = scale * random.uniform([0.5, 1.5], [2.5, 4.0])
        level = full * random.uniform(-1.0, 1.0)
        corners += [corners[-1] + swing, corners[-1] + swing + hold]
        levels += [level, level]
    return np.interp(time, corners, levels)


def heading_reference(time: Array, vehicle: Vehicle, random: np.random.Generator, start: float) -> Array:
    """(ticks,) headings to hold [rad]: steps to either side, about as far as the vehicle turns in its time scale."""
    turn = vehicle.full_rate * vehicle.time_scale
    reference = np.empty(time.size)
    target, due = start, 0.0
    for k, t in enumerate(time.tolist()):
        if t >= due:
            back = -math.copysign(1.0, target - start) if abs(target - start) > 1.5 * turn else random.choice([-1, 1])
            target += float(back) * turn * random.uniform(0.5, 1.8)
            due = t + vehicle.time_scale * random.uniform(4.0, 9.0)
        reference[k] = target
    return reference


def rate_pi(reference: Array, vehicle: Vehicle, period: float) -> Pilot:
    """A PI controller of the yaw rate; it stops to integrate while it asks for more than there is."""
    gain = min(1.3 / vehicle.time_scale, 0.25 / period) * vehicle.inertia
    per_step = gain * period / (1.5 * vehicle.time_scale)
    wanted, full, integral = reference.tolist(), vehicle.full_torque, 0.0

    def pilot(tick: int, yaw_rate: float, _heading: float) -> float:
        nonlocal integral
        error = wanted[tick] - yaw_rate
        asked = float(gain * error + integral)
        if abs(asked) < full or asked * error < 0.0:
            integral += per_step * error
        return asked

    return pilot


def heading_pd(reference: Array, vehicle: Vehicle, period: float) -> Pilot:
    """A PD controller of the heading, with the logged yaw rate for its D part."""
    natural = min(1.0 / vehicle.time_scale, 0.2 / period)
    stiffness = vehicle.inertia * natural**2
    damping = 0.9 * vehicle.inertia * natural
    wanted = reference.tolist()

    def pilot(tick: int, yaw_rate: float, heading: float) -> float:
        return float(stiffness * (wanted[tick] - heading) - damping * yaw_rate)

    return pilot


CLOSED_LOOP = ("heading_pd", "rate_pi")
COMMANDS = (*OPEN_LOOP, *CLOSED_LOOP)


def pilot_of(command: str, vehicle: Vehicle, time: Array, start: float, random: np.random.Generator) -> Pilot:
    """The pilot of one run.

    Args:
        command: one of COMMANDS.
        vehicle: which is commanded.
        time: (ticks,) when the pilot is called [s], evenly.
        start: heading at the beginning [rad].
        random: the command's own chance.

    Raises:
        KeyError: no command has this name.
    """
    period, full = float(time[1] - time[0]), vehicle.full_torque
    steps = int(random.choice(THRUSTER_STEPS))
    if command == "rate_pi":
        asks = rate_pi(rate_reference(time, vehicle, random), vehicle, period)
    elif command == "heading_pd":
        asks = heading_pd(heading_reference(time, vehicle, random, start), vehicle, period)
    else:
        program = (full * OPEN_LOOP[command](time, vehicle.time_scale, random)).tolist()

        def asks(tick: int, _rate: float, _heading: float) -> float:
            return float(program[tick])

    def pilot(tick: int, yaw_rate: float, heading: float) -> float:
        moment = min(max(asks(tick, yaw_rate, heading), -full), full)
        return round(moment / full * steps) * full / steps if steps else moment

    return pilot


def usual_swing(command: str, vehicle: Vehicle, duration: float) -> float:
    """How far the heading usually is from its start [rad], which tells how stiff a tether is that matters.

    Most programs let it go like a random walk: it was 0.13 to 0.98 of R T √(2 duration / 3 T), with a
    median of 0.3. What holds the heading, or never turns for long to one side, keeps it within about R T.
    """
    turn = vehicle.full_rate * vehicle.time_scale
    if command in ("heading_pd", "noise_band"):
        return turn
    return 0.3 * turn * math.sqrt(2.0 * duration / (3.0 * vehicle.time_scale))


def computer_period(vehicle: Vehicle, random: np.random.Generator) -> float:
    """The period of the pilot's computer [s]."""
    return float(random.choice([p for p in PERIODS if p <= MAX_PERIOD_SHARE * vehicle.time_scale]))
