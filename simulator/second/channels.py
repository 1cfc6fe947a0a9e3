"""The true courses of further channels. None follows from the yaw motion; an effect may follow from one of them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from simulator.second.plant import STEP, Array

Course = Callable[[Array, float, np.random.Generator], Array]
"""(time of the steps (n,) [s], the vehicle's time scale [s], chance) -> values (n,)."""


def wandering(count: int, correlation_time: float, random: np.random.Generator) -> Array:
    """(count,) an Ornstein–Uhlenbeck process of deviation 1, exact at the steps."""
    decay = math.exp(-STEP / correlation_time)
    white = random.standard_normal(count)
    white[0] /= math.sqrt(1.0 - decay**2)
    return np.asarray(lfilter([math.sqrt(1.0 - decay**2)], [1.0, -decay], white), dtype=np.float64)


def between_levels(
    time: Array, holds: tuple[float, float], moves: tuple[float, float], random: np.random.Generator
) -> Array:
    """Lines between levels of 0 to 1, each held for a while: ranges of the holds and of the moves [s]."""
    corners, levels = [0.0], [float(random.uniform())]
    while corners[-1] < time[-1]:
        start = corners[-1] + random.uniform(*holds)
        corners += [start, start + random.uniform(*moves)]
        levels += [levels[-1], float(random.uniform())]
    return np.interp(time, corners, levels)


def sway(time: Array, scale: float, random: np.random.Generator) -> Array:
    """[m/s] Pushed sideways by hand and by gusts."""
    return 0.12 * wandering(time.size, 2.0 * scale, random) + 0.06 * wandering(time.size, 9.0 * scale, random)


def surge(time: Array, scale: float, random: np.random.Generator) -> Array:
    """[m/s] Legs at a speed, ahead and astern."""
    legs = between_levels(time, (3.0 * scale, 9.0 * scale), (0.8 * scale, 2.0 * scale), random)
    return 1.2 * legs - 0.5 + 0.04 * wandering(time.size, scale, random)


def roll_rate(time: Array, scale: float, random: np.random.Generator) -> Array:
    """[rad/s] Rolling in a sea whose height comes and goes."""
    angle = np.cumsum(2.0 * math.pi * STEP / (3.1 * scale) * (1.0 + 0.25 * wandering(time.size, 5.0 * scale, random)))
    return 0.1 * np.sin(angle) * (1.0 + 0.4 * np.tanh(wandering(time.size, 12.0 * scale, random)))


def crane_angle(time: Array, scale: float, random: np.random.Generator) -> Array:
    """[rad] An arm slews from place to place, to either side."""
    return 2.4 * between_levels(time, (scale, 7.0 * scale), (0.7 * scale, 3.0 * scale), random) - 1.2


def pump_flow(time: Array, scale: float, random: np.random.Generator) -> Array:
    """[l/s] A pump that runs, now weaker, now stronger, and often stands still."""
    running = between_levels(time, (1.5 * scale, 6.0 * scale), (0.3 * scale, 0.8 * scale), random)
    return 3.0 * np.maximum(running - 0.4, 0.0)


def voltage(time: Array, _scale: float, random: np.random.Generator) -> Array:
    """[V] A battery that empties, sags under other loads, and was charged in between."""
    duration = float(time[-1])
    charged = duration * random.uniform(0.45, 0.7)
    empty = np.where(time < charged, time / duration, 0.6 * (time - charged) / duration)
    loads = between_levels(time, (0.03 * duration, 0.1 * duration), (0.5, 3.0), random)
    return 51.0 - 9.0 * empty - 3.0 * loads


def hose_pressure(time: Array, _scale: float, random: np.random.Generator) -> Array:
    """[bar] An accumulator that drains and is pumped up again."""
    cycle = float(time[-1]) * random.uniform(0.06, 0.12)
    phase = np.mod(time / cycle + random.uniform(), 1.0)
    return 190.0 - 60.0 * np.where(phase < 0.8, phase / 0.8, 5.0 * (1.0 - phase))


def depth(time: Array, _scale: float, random: np.random.Generator) -> Array:
    """[m] Down, along, up, along."""
    duration = float(time[-1])
    legs = between_levels(time, (0.02 * duration, 0.08 * duration), (0.02 * duration, 0.08 * duration), random)
    return 9.0 + 14.0 * legs + 0.1 * wandering(time.size, 4.0, random)


def temperature(time: Array, _scale: float, random: np.random.Generator) -> Array:
    """[°C] Of the oil: it warms up while other loads run, and cools, both slowly."""
    loads = between_levels(time, (20.0, 90.0), (2.0, 5.0), random)
    decay = math.exp(-STEP / (0.08 * float(time[-1])))
    warmed = lfilter([1.0 - decay], [1.0, -decay], loads, zi=[decay * float(loads[0])])[0]
    return 14.0 + 16.0 * np.asarray(warmed, dtype=np.float64)


CHANNELS: dict[str, Course] = {
    "sway": sway,
    "surge": surge,
    "roll_rate": roll_rate,
    "crane_angle": crane_angle,
    "pump_flow": pump_flow,
    "voltage": voltage,
    "hose_pressure": hose_pressure,
    "depth": depth,
    "temperature": temperature,
}
