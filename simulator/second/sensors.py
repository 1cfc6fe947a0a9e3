"""What is logged: each sensor by its own clock, with its own noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulator.second.plant import STEP, Array

JITTER = 0.08
"""Most by which a stamp is early or late, in a clock's period."""
SPIKES = 0.001
"""Share of the samples of a measured torque that are spikes."""


@dataclass(frozen=True, slots=True)
class Clocked:
    """A sensor's stamps and noise, drawn before the run, so that its controller sees what is logged.

    Attributes:
        stamps: (m,) [s], strictly increasing.
        noise: (m,) white, in the sensor's unit.
    """

    stamps: Array
    noise: Array


def clocked(
    duration: float, rates: tuple[float, float], deviations: tuple[float, float], random: np.random.Generator
) -> Clocked:
    """A sensor with a rate [Hz] and a white noise of these ranges."""
    period = 1.0 / random.uniform(*rates)
    deviation = random.uniform(*deviations)
    ticks = np.arange(int(duration / period) - 1, dtype=np.float64)
    stamps = period * (ticks + random.uniform(0.2, 1.0) + random.uniform(-JITTER, JITTER, ticks.size))
    return Clocked(stamps, deviation * random.standard_normal(ticks.size))


def logged_course(values: Array, rates: tuple[float, float], random: np.random.Generator) -> tuple[Array, Array]:
    """Stamps and samples of a further channel, with a noise of 1 % of how much it varies."""
    spread = float(np.std(values))
    sensor = clocked(values.size * STEP, rates, (0.01 * spread, 0.01 * spread), random)
    true = np.interp(sensor.stamps, STEP * np.arange(values.size, dtype=np.float64), values)
    return sensor.stamps, true + sensor.noise


def measured_torque(
    command: Array, period: float, full_torque: float, random: np.random.Generator
) -> tuple[Array, Array]:
    """Stamps [s] and samples [N m] of a torque that is measured: what is asked, white noise, and rare spikes.

    Args:
        command: (ticks,) as it was asked and held [N m].
        period: of its ticks [s].
        full_torque: the vehicle's [N m]; the noise is 1 to 4 % of it.
        random: this sensor's chance.
    """
    sensor = clocked(command.size * period, (10.0, 50.0), (0.01 * full_torque, 0.04 * full_torque), random)
    held = command[np.minimum((sensor.stamps / period).astype(int), command.size - 1)]
    spiky = random.random(sensor.stamps.size) < SPIKES
    heights = full_torque * random.choice([-1.0, 1.0], sensor.stamps.size) * random.uniform(0.3, 1.0, spiky.size)
    return sensor.stamps, held + sensor.noise + np.where(spiky, heights, 0.0)
