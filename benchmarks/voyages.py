"""Voyages of the simulated Leng, and what can go wrong with its sensors.

A plain plant of its own, quick enough for a day: I ṙ = τ + w(t) − (1 + h(t)) d(r), with the water's moment w and the
hull's share h. Driven by sinusoids, slow and fast turns, held commands, a heading controller on straight legs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from simulator import leng

STEP_S = 0.04
"""Step of the integration, and period of the torque [s]."""
PERIODS_S = {"yaw_rate": 0.02, "torque": STEP_S, "heading": 0.2}
GYRO_NOISE, VIBRATION, TORQUE_NOISE, HEADING_NOISE = 0.0070, 0.0074, 0.3, 0.01
"""Standard deviations of a cheap gyro while the rotors stand, and what they add at full torque [rad/s], growing with
their speed squared; of the torque [N m]; of the heading [rad]."""
HOLD_GAINS = (60.0, 150.0)
"""Gains of the heading controller on straight legs [N m/rad], [N m s/rad]."""
STRAIGHT_S, HULL_PERIOD_S = 2400.0, 7200.0
"""A day has one straight leg of so long [s]; the hull is mounted or taken off so often [s]."""

Bools = NDArray[np.bool_]
Stream = tuple[Array, Array]
Streams = dict[str, Stream]


@dataclass(frozen=True, slots=True)
class Voyage:
    """What the sensors of a vehicle measure, and the truth.

    Attributes:
        streams: name → (stamps [s], values).
        hull: (n,) the hull's share of the damping at each STEP_S.
    """

    streams: Streams
    hull: Array

    def damping(self, rates: Array, at: float) -> Array:
        """d [N m] at yaw rates at a time [s]."""
        return np.asarray((1.0 + self.hull[min(int(at / STEP_S), self.hull.size - 1)]) * leng.damping(rates))


def experiment(seed: int, seconds: float, hull_at: float = np.inf) -> Voyage:
    """The paper's sinusoid, with the hull from `hull_at` [s] on."""
    rng = np.random.default_rng([seed, 1])
    t = STEP_S * np.arange(round(seconds / STEP_S), dtype=np.float64)
    command = 100.0 * np.sin(2.0 * np.pi * t / 67.0 + rng.uniform(0.0, 2.0 * np.pi))
    return _driven(rng, t, command, t < 0.0, np.where(t >= hull_at, leng.HULL, 0.0), np.zeros(t.size))


def day(seed: int, seconds: float) -> Voyage:
    """Legs of turns, of held commands, of straight driving; the hull comes and goes, and so does a swell of 3 N m."""
    rng = np.random.default_rng([seed, 2])
    t = STEP_S * np.arange(round(seconds / STEP_S), dtype=np.float64)
    command, straight, began, waits = np.zeros(t.size), np.zeros(t.size, dtype=bool), 0.0, seconds > 10_000.0
    while began < seconds:
        kind, length = (
            rng.choice(["sine", "steps", "straight", "sweep"], p=[0.4, 0.3, 0.15, 0.15]),
            rng.uniform(120, 900),
        )
        if waits and began >= 0.5 * seconds:
            kind, length, waits = "straight", STRAIGHT_S, False
        here = (t >= began) & (t < began + length)
        straight[here] = kind == "straight"
        command[here] = _commanded(rng, kind, t[here] - began, length)
        began += length
    waves = sum(np.sin(2.0 * np.pi * t / rng.uniform(5.0, 10.0) + rng.uniform(0.0, 6.3)) for _ in range(12))
    swell = waves / np.sqrt(6.0) * (0.5 - 0.5 * np.cos(2.0 * np.pi * t / 21_600.0 + rng.uniform(0.0, 6.3)))
    return _driven(rng, t, command, straight, np.where((t // HULL_PERIOD_S) % 2 == 1, leng.HULL, 0.0), 3.0 * swell)


def _commanded(rng: np.random.Generator, kind: str, t: Array, length: float) -> Array:
    """The torque [N m] of a leg at times from its beginning [s]; that of a heading controller is not known before."""
    if kind == "sine":
        return np.asarray(rng.uniform(40.0, 100.0) * np.sin(2.0 * np.pi * t / rng.uniform(20.0, 90.0)))
    if kind == "sweep":
        return np.asarray(80.0 * np.sin(2.0 * np.pi * t * (0.01 + 0.03 * t / length)))
    if kind == "steps":
        number = np.cumsum(rng.random(t.size) < STEP_S / 15.0)
        return np.asarray(rng.choice([-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0], int(number[-1]) + 1)[number])
    return np.zeros(t.size)


def _driven(rng: np.random.Generator, t: Array, command: Array, straight: Bools, hull: Array, water: Array) -> Voyage:
    """The motion by the midpoint rule, and what the sensors measure of it with clocks of their own."""
    r = psi = wanted = 0.0
    motion, held = np.zeros((3, t.size)), False
    inertia, (by_heading, by_rate) = leng.INERTIA, HOLD_GAINS
    steps = zip(command.tolist(), straight.tolist(), (1.0 + hull).tolist(), water.tolist(), strict=True)
    for k, (tau, hold, part, moment) in enumerate(steps):
        if hold:
            wanted = wanted if held else psi
            tau = max(-100.0, min(100.0, by_heading * (wanted - psi) - by_rate * r))
        held = hold
        motion[:, k] = r, tau, psi
        middle = r + 0.5 * STEP_S * (tau + moment - part * leng.damping(r)) / inertia
        r += STEP_S * (tau + moment - part * leng.damping(middle)) / inertia
        psi += STEP_S * middle
    streams = {}
    for (name, period), values in zip(PERIODS_S.items(), motion, strict=True):
        stamps = np.arange(rng.uniform(0.0, period), t[-1], period)
        stamps = (stamps + rng.uniform(0.0, 0.1 * period, stamps.size)).round(6)
        noise = {"torque": TORQUE_NOISE, "heading": HEADING_NOISE}.get(name, 0.0)
        if name == "yaw_rate":
            noise = np.hypot(GYRO_NOISE, VIBRATION * (np.interp(stamps, t, motion[1]) / 100.0) ** 2)
        streams[name] = stamps, np.interp(stamps, t, values) + rng.normal(0.0, noise, stamps.size)
    heading = (streams["heading"][1] + np.pi) % (2.0 * np.pi) - np.pi
    return Voyage(streams | {"heading": (streams["heading"][0], heading)}, hull)


def with_outliers(streams: Streams, part: float, rng: np.random.Generator) -> Streams:
    """A part of the values of yaw rate and torque is anywhere within twice their range."""
    return streams | {name: (t, _wild(v, np.ones(t.size, dtype=bool), part, rng))
                      for name, (t, v) in streams.items() if name != "heading"}  # fmt: skip


def with_drop_outs(streams: Streams, a_minute: float, rng: np.random.Generator) -> Streams:
    """Each stream is silent now and then, for a second on average."""
    found = {}
    for name, (t, value) in streams.items():
        kept = np.ones(t.size, dtype=bool)
        for start in np.flatnonzero(rng.random(t.size) < a_minute / 60.0 * np.median(np.diff(t))):
            kept[start : int(np.searchsorted(t, t[start] + rng.exponential(1.0)))] = False
        found[name] = (t[kept], value[kept])
    return found


def _frozen(value: Array, here: Bools) -> Array:
    return np.where(here, value[np.argmax(here)], value)


def _wild(value: Array, here: Bools, part: float, rng: np.random.Generator) -> Array:
    reach = 2.0 * float(np.quantile(np.abs(value), 0.99))
    wild = here & (rng.random(value.size) < part)
    return np.asarray(np.where(wild, rng.uniform(-reach, reach, value.size), value))


def _fast(t: Array, here: Bools) -> Array:
    return np.asarray(t + 0.005 * here * (t - t[np.argmax(here)]))


Fault = tuple[str, Callable[[Array, Array, Bools, np.random.Generator], Stream]]
"""Its stream, and (stamps, values, where they are at fault, rng) → the same at fault."""
FAULTS: Mapping[str, Fault] = {
    "yaw rate's sign reversed": ("yaw_rate", lambda t, v, here, rng: (t, np.where(here, -v, v))),
    "torque's sign reversed": ("torque", lambda t, v, here, rng: (t, np.where(here, -v, v))),
    "torque frozen": ("torque", lambda t, v, here, rng: (t, _frozen(v, here))),
    "torque stuck at zero": ("torque", lambda t, v, here, rng: (t, np.where(here, 0.0, v))),
    "torque clipped at ±60 N m": ("torque", lambda t, v, here, rng: (t, np.where(here, np.clip(v, -60, 60), v))),
    "torque halved": ("torque", lambda t, v, here, rng: (t, np.where(here, 0.5 * v, v))),
    "a dead thruster": ("torque", lambda t, v, here, rng: (t, np.where(here, 2.0 * v, v))),
    "20 % outliers, torque": ("torque", lambda t, v, here, rng: (t, _wild(v, here, 0.2, rng))),
    "20 % outliers, gyro": ("yaw_rate", lambda t, v, here, rng: (t, _wild(v, here, 0.2, rng))),
    "gyro + 0.05 rad/s": ("yaw_rate", lambda t, v, here, rng: (t, v + 0.05 * here)),
    "gyro frozen": ("yaw_rate", lambda t, v, here, rng: (t, _frozen(v, here))),
    "gyro frozen, last bit toggles": (
        "yaw_rate", lambda t, v, here, rng: (t, _frozen(v, here) + 1e-6 * here * rng.integers(0, 2, t.size))),
    "gyro clipped at ±0.15 rad/s": (
        "yaw_rate", lambda t, v, here, rng: (t, np.where(here, np.clip(v, -0.15, 0.15), v))),
    "yaw rate in deg/s": ("yaw_rate", lambda t, v, here, rng: (t, np.where(here, np.rad2deg(v), v))),
    "torque's clock 0.5 % fast": ("torque", lambda t, v, here, rng: (_fast(t, here), v)),
    "gyro's clock 0.5 % fast": ("yaw_rate", lambda t, v, here, rng: (_fast(t, here), v)),
    "torque stamped 2 s late": ("torque", lambda t, v, here, rng: (t + 2.0 * here, v)),
    "gyro stamped 2 s late": ("yaw_rate", lambda t, v, here, rng: (t + 2.0 * here, v)),
}  # fmt: skip
CHANGES_VEHICLE = ("torque halved", "a dead thruster")
"""No two streams distinguish these from a vehicle that changed: they are to be named alone."""
