"""What a trial vehicle's recorder gets to see: noise, steps, spikes, and streams with their own clocks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulator.noise import lasting_noise
from simulator.trial_effects import Scale
from simulator.trial_effects.physics import Array
from simulator.trial_vehicle import STEP, Gyro, Motion


@dataclass(frozen=True, slots=True)
class Noise:
    """How the residual's noise divides: water that moves the vehicle, and the torque's sensor.

    Attributes:
        total: deviation of τ − I ṙ − d(r) [N m].
        water_share: share of its variance that lies in the water.
        water_memory: autocorrelation of the water's part over PERIOD.
        sensor_memory: the same of the torque's sensor.
    """

    total: float
    water_share: float
    water_memory: float
    sensor_memory: float = 0.0

    @staticmethod
    def drawn(total: float, autocorrelation: float, random: np.random.Generator) -> Noise:
        """A division whose sum has the given autocorrelation over PERIOD: water share times water memory.

        The more memory the water has, the smaller is its share and the whiter the rest: an ARMA(1, 1) residual.
        """
        if autocorrelation == 0:
            return Noise(total, random.uniform(0.0, 1.0), 0.0)
        memory = random.uniform(autocorrelation, (1 + autocorrelation) / 2)
        return Noise(total, autocorrelation / memory, memory)

    def water(self, count: int, random: np.random.Generator) -> Array:
        """(count,) [N m], one value for each PERIOD."""
        memory = self.water_memory
        kicks = random.standard_normal(count) * np.sqrt(1 - memory**2)
        values = lasting_noise(float(random.standard_normal()), memory, kicks)
        return values * float(self.total * np.sqrt(self.water_share))

    @staticmethod
    def in_the_torque(total: float, autocorrelation: float) -> Noise:
        """All of it in the torque's sensor, as in a textbook: nothing but the thrust moves the vehicle."""
        return Noise(total, 0.0, 0.0, autocorrelation)

    @staticmethod
    def in_the_water(total: float, autocorrelation: float) -> Noise:
        """All of it in the water: the torque is what was commanded."""
        return Noise(total, 1.0, autocorrelation)

    @property
    def sensor(self) -> float:
        """Deviation of the torque's sensor [N m]."""
        return float(self.total * np.sqrt(1 - self.water_share))


PERIOD = 0.05
"""[s] of the recorder's clock; the water's noise holds for as long."""


@dataclass(frozen=True, slots=True)
class Recorder:
    """The sensors of one trial.

    Attributes:
        scale: the vehicle's.
        apart: whether every stream has its own rate, offset and jitter, or all share one clock.
        gyro_noise, gyro_step: deviation and resolution of the yaw rate [rad/s].
        torque_noise, torque_step: the same of the torque [N m].
        torque_memory: autocorrelation of the torque's noise over PERIOD.
        spikes: whether the gyro spikes too (one sample in 300); the torque does in one of 100.
        wraps: whether the heading jumps from π to −π.
    """

    scale: Scale
    apart: bool
    gyro_noise: float
    gyro_step: float
    torque_noise: float
    torque_memory: float
    torque_step: float
    spikes: bool
    wraps: bool

    @staticmethod
    def drawn(scale: Scale, noise: Noise, random: np.random.Generator) -> Recorder:
        """Sensors of a usual quality."""
        return Recorder(
            scale=scale,
            apart=bool(random.random() < 0.5),
            gyro_noise=scale.rate * random.uniform(4e-4, 16e-4),
            gyro_step=scale.rate * 6e-4 if random.random() < 0.5 else 0.0,
            torque_noise=noise.sensor,
            torque_memory=noise.sensor_memory,
            torque_step=scale.torque * random.uniform(0.01, 0.025) if random.random() < 0.4 else 0.0,
            spikes=bool(random.random() < 0.4),
            wraps=bool(random.random() < 0.5),
        )

    def stamps(self, end: float, frequency: float, random: np.random.Generator) -> Array:
        """When a stream of the given frequency [Hz] is sampled, up to `end` [s]; on a common clock all at its rate."""
        if not self.apart:
            return PERIOD * np.arange(round(end / PERIOD), dtype=np.float64)
        period = 1 / frequency
        count = int(end / period) - 1
        jitter = period * random.choice([0.0, 0.05]) * random.uniform(-1, 1, count)
        return np.asarray(np.round(np.abs(random.uniform(0, period) + np.arange(count) * period + jitter), 4))

    def measured_torque(self, time: Array, command: Array, total: float, random: np.random.Generator) -> Array:
        """The command as a sensor sees it: noise, steps, one outlier in a hundred."""
        values = command + self.torque_noise * _remembering(random.standard_normal(time.size), time, self.torque_memory)
        hit = random.random(time.size) < 0.01
        spike = total * random.uniform(5, 14, time.size) * random.choice([-1.0, 1.0], time.size)
        dropped = bool(random.random() < 0.3)
        values = np.where(hit, 0.0 if dropped else values + spike, values)
        return _stepped(values, self.torque_step)

    def commanded_torque(self, motion: Motion, hold: int, random: np.random.Generator) -> tuple[Array, Array]:
        """The commands as they were given, each stamped when it arrived in the log."""
        latency = 0.02 * STEP * hold * np.abs(random.standard_normal(-(-motion.time.size // hold)))
        time = motion.time[::hold] + (np.minimum(latency, 0.2 * STEP * hold).round(4) if self.apart else 0.0)
        return time, motion.command[::hold]

    def gyro(self, end: float, random: np.random.Generator) -> Gyro:
        """When the gyro samples until `end` [s], and what it is off."""
        time = self.stamps(end, 20.0, random)
        error = self.gyro_noise * random.standard_normal(time.size)
        if self.spikes:
            hit = random.random(time.size) < 1 / 300
            error = np.where(hit, error + self.scale.rate * random.uniform(-0.4, 0.4, time.size), error)
        return Gyro(time, error, self.gyro_step)

    def heading(self, heading: Array, random: np.random.Generator) -> Array:
        """The compass."""
        values = heading + 0.01 * random.standard_normal(heading.size)
        return np.asarray((values + np.pi) % (2 * np.pi) - np.pi) if self.wraps else values


def _remembering(kicks: Array, time: Array, memory: float) -> Array:
    """Noise of deviation one that remembers: an Ornstein-Uhlenbeck process at the stamps, out of white kicks."""
    if memory == 0.0:
        return kicks
    kept = memory ** (np.diff(time, prepend=time[0]) / PERIOD)
    value, values = float(kicks[0]), list[float]()
    for keep, kick in zip(kept.tolist(), kicks.tolist(), strict=True):
        value = keep * value + math.sqrt(1.0 - keep**2) * kick
        values.append(value)
    return np.array(values)


def _stepped(values: Array, step: float) -> Array:
    return np.asarray(np.round(values / step) * step, np.float64) if step else values
