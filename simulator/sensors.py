"""What a vehicle logs: every sensor by its own clock, with its own delay and noise; further channels; the log."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES
from simulator.physics import STEP
from simulator.vehicles import Vehicle

QUANTITIES = (*VELOCITIES, *ATTITUDE, "heading", *EFFORTS)
"""What the world can sample: velocities over ground, angles, commanded efforts, under the names of recordings."""
HEADING, EFFORT = QUANTITIES.index("heading"), QUANTITIES.index(EFFORTS[0])
"""Where the heading is, and the first of the efforts."""
GYRO_NOISE = 0.002
"""Deviation of an ordinary gyro's white noise [rad/s]."""
COMPASS_NOISE = 0.003
"""[rad]"""


@dataclass(frozen=True, slots=True)
class Sensor:
    """One stream of the log.

    Attributes:
        quantity: of QUANTITIES.
        rate: how often it samples [Hz].
        noise: its white noise's deviation, in its unit.
        latency: what a sample takes to its stamp [s].
        jitter: most by which a sample is early or late, in its period.
        phase: of the first sample, in its period; None draws one.
        resolution: its step, 0 for none.
        spikes: share of samples that are off by up to `spike`.
        wraps: whether the angle jumps from π to −π.
    """

    quantity: str
    rate: float
    noise: float = 0.0
    latency: float = 0.0
    jitter: float = 0.0
    phase: float | None = None
    resolution: float = 0.0
    spikes: float = 0.0
    spike: float = 0.0
    wraps: bool = False


@dataclass(frozen=True, slots=True)
class Samples:
    """When a sensor samples, when it says so, and how wrong it is.

    Attributes:
        at, stamps: (n,) [s], increasing.
        error: (n,) in its unit.
    """

    at: Array
    stamps: Array
    error: Array


def schedule(sensor: Sensor, duration: float, random: np.random.Generator) -> Samples:
    """The samples of a mission of this length [s]."""
    period = 1.0 / sensor.rate
    phase = float(random.uniform()) if sensor.phase is None else sensor.phase
    ticks = phase + np.arange(math.ceil(duration * sensor.rate), dtype=np.float64)
    at = period * (ticks + sensor.jitter * random.uniform(-1.0, 1.0, ticks.size))
    at = at[(at >= 0.0) & (at + sensor.latency <= duration)]
    error = sensor.noise * random.standard_normal(at.size)
    if sensor.spikes:
        struck = random.random(at.size) < sensor.spikes
        error = np.where(struck, error + sensor.spike * random.uniform(-1.0, 1.0, at.size), error)
    return Samples(at, np.round(at + sensor.latency, 6), error)


def seen(sensor: Sensor, values: Array) -> Array:
    """What the log keeps of noisy values."""
    if sensor.resolution:
        values = np.round(values / sensor.resolution) * sensor.resolution
    return np.asarray((values + np.pi) % (2.0 * np.pi) - np.pi if sensor.wraps else values)


def at_beats(vehicle: Vehicle, rate: float) -> tuple[Sensor, ...]:
    """The sensors that a controller reads at its beats [Hz] and logs with its commands: gyro and compass."""
    noise = {"heading": COMPASS_NOISE, "yaw_rate": GYRO_NOISE}
    return tuple(Sensor(name, rate, noise[name], phase=0.0, wraps=name == "heading") for name in noise)


def own_clocks(vehicle: Vehicle, random: np.random.Generator) -> tuple[Sensor, ...]:
    """A gyro and a compass of a usual quality on clocks of their own; the gyro may be coarse, and spike."""
    full = vehicle.rate
    gyro = Sensor(
        "yaw_rate", float(random.uniform(20.0, 50.0)), full * random.uniform(4e-4, 5e-3), latency=0.002, jitter=0.08,
        resolution=full * 6e-4 if random.random() < 0.5 else 0.0,
        spikes=1.0 / 300.0 if random.random() < 0.3 else 0.0, spike=0.4 * full,
    )  # fmt: skip
    compass = Sensor("heading", 10.0, float(random.uniform(0.002, 0.01)), latency=0.01, wraps=random.random() < 0.5)
    return gyro, compass


def torque_sensor(vehicle: Vehicle, random: np.random.Generator) -> Sensor:
    """A torque that is measured: noise of 1 to 4 % of the full one, now and then a spike, perhaps coarse."""
    full = vehicle.torque
    return Sensor(
        "torque", float(random.choice([10.0, 20.0, 25.0])), full * random.uniform(0.01, 0.04), jitter=0.05,
        resolution=full * random.uniform(0.01, 0.025) if random.random() < 0.4 else 0.0, spikes=0.005, spike=0.5 * full,
    )  # fmt: skip


def whole(vehicle: Vehicle, rate: float = 10.0, along: float = 0.005, about: float = 0.003) -> tuple[Sensor, ...]:
    """Velocities and angles of all axes that move, by one clock, with this white noise [m/s], [rad/s]."""
    rates = [Sensor(AXES[name].rate, rate, along if AXES[name].along else about, phase=0.0) for name in vehicle.moves]
    angles = [name for name in ("roll", "pitch") if name in vehicle.moves]
    return (*rates, *(Sensor(name, rate, phase=0.0) for name in (*angles, "heading")))


# Of each further channel: its centre, its deviation, its correlation time in I r/τ, how often it is logged [Hz], its
# sensor's noise in deviations, and its change over the mission.
_CHANNELS = {
    "winch_load": (40.0, 12.0, 25.0, 5.0, 0.05, 0.0),
    "ballast_flow": (0.0, 0.3, 12.0, 4.0, 0.1, 0.0),
    "arm_angle": (0.4, 0.35, 30.0, 10.0, 0.02, 0.0),
    "mast_sway": (0.0, 0.15, 5.0, 10.0, 0.05, 0.0),
    "depth": (6.0, 1.5, 60.0, 5.0, 0.01, 0.0),
    "voltage": (16.4, 0.3, 25.0, 2.0, 0.1, -1.2),
    "temperature": (12.0, 0.3, 120.0, 1.0, 0.05, -1.5),
}
CHANNELS = tuple(_CHANNELS)
"""Further channels that a vehicle may log. None follows from its motion; an effect may follow from one of them."""
CHANNEL_STEP = 0.05
"""Of a channel's true course [s]."""


def channel(name: str, duration: float, unit: float, random: np.random.Generator) -> tuple[Array, Array]:
    """A channel's true course: times [s] and values.

    Args:
        name: of CHANNELS.
        duration: [s].
        unit: the vehicle's I r/τ [s].
        random: draws the course.

    Raises:
        KeyError: no such channel.
    """
    centre, deviation, memory, _, _, change = _CHANNELS[name]
    time: Array = CHANNEL_STEP * np.arange(math.ceil(duration / CHANNEL_STEP) + 2, dtype=np.float64)
    # Noise through a filter that falls off as a Gaussian. Its course is periodic; of a longer one the ends do not meet.
    count = time.size + round(8.0 * memory * unit / CHANNEL_STEP)
    frequencies = np.fft.rfftfreq(count, CHANNEL_STEP)
    spectrum = np.exp(-0.5 * (np.pi * frequencies * memory * unit) ** 2) * (
        random.standard_normal(frequencies.size) + 1j * random.standard_normal(frequencies.size)
    )
    spectrum[0] = 0.0
    course = np.fft.irfft(spectrum, count)
    return time, centre + change * time / time[-1] + deviation * course[: time.size] / np.std(course)


def logged(name: str, course: tuple[Array, Array], duration: float, random: np.random.Generator) -> tuple[Array, Array]:
    """Stamps and samples of a channel."""
    noise = _CHANNELS[name][4] * float(np.std(course[1]))
    samples = schedule(Sensor(name, _CHANNELS[name][3], noise, jitter=0.05), duration, random)
    return samples.stamps, np.interp(samples.at, *course) + samples.error


class Log:
    """The log of missions.

    Args:
        samples: of each mission by quantity: when it is sampled, and how wrongly.

    Attributes:
        values: of each mission by quantity (n,), as sampled.
        seen: (missions, quantities) what has come last.
    """

    def __init__(self, samples: Sequence[dict[str, Samples]]) -> None:
        streams = [(k, name, each) for k, own in enumerate(samples) for name, each in own.items()]
        sizes = [each.at.size for *_, each in streams]
        self._mission = np.repeat([k for k, *_ in streams], sizes).astype(np.intp)
        self._quantity = np.repeat([QUANTITIES.index(name) for _, name, _ in streams], sizes).astype(np.intp)
        self._at, self._stamp, self._error = (
            np.concatenate([getattr(each, name) for *_, each in streams]) for name in ("at", "stamps", "error")
        )
        self._taken, self._arrived = np.argsort(self._at, kind="stable"), np.argsort(self._stamp, kind="stable")
        self._sorted_at, self._sorted_stamp = self._at[self._taken], self._stamp[self._arrived]
        self._value = np.zeros(self._at.size)
        self._next = self._next_stamp = 0
        parts = np.split(self._value, np.cumsum(sizes)[:-1])
        self.values = [
            {name: part for (of, name, _), part in zip(streams, parts, strict=True) if of == k}
            for k in range(len(samples))
        ]
        self.seen = np.zeros((len(samples), len(QUANTITIES)))

    def take(self, now: float, length: float, chunk: Array) -> None:
        """Samples until now [s] of the chunk (steps + 1, missions, quantities) that ends now and is so long [s]."""
        end = int(np.searchsorted(self._sorted_at, now + 1e-9, side="right"))
        if end > self._next:
            which = self._taken[self._next : end]
            place = np.clip((self._at[which] - (now - length)) / STEP, 0.0, chunk.shape[0] - 1)
            below = np.minimum(place.astype(np.intp), chunk.shape[0] - 2)
            mission, quantity = self._mission[which], self._quantity[which]
            before, after = chunk[below, mission, quantity], chunk[below + 1, mission, quantity]
            self._value[which] = before + (place - below) * (after - before) + self._error[which]
            self._next = end
        if self._next_stamp == 0:
            self.seen[:, HEADING] = chunk[-1, :, HEADING]
        arrived = int(np.searchsorted(self._sorted_stamp, now + 1e-9, side="right"))
        if arrived > self._next_stamp:
            which = self._arrived[self._next_stamp : arrived]
            self.seen[self._mission[which], self._quantity[which]] = self._value[which]
            self._next_stamp = arrived
