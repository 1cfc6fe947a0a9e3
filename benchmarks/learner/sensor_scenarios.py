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
GYRO_PERIOD_S, HEADING_PERIOD_S = 0.02, 0.2
TORQUE_NOISE, HEADING_NOISE = 0.3, 0.01
"""Standard deviations [N m], [rad]."""
GYRO_NOISE, VIBRATION = 0.0070, 0.0074
"""A cheap gyro's standard deviation [rad/s] while the rotors stand, and what they add at full torque; it grows with
their speed squared. Most of what a sample is off by is the gyro's here, where simulator.leng has it in the water."""
HOLD_GAINS = (60.0, 150.0)
"""Gains of the heading controller on straight legs [N m/rad], [N m s/rad]."""
MAX_STRAIGHT_S = 2400.0
"""The longest straight leg [s], once in each voyage of two hours or more."""
HULL_PERIOD_S = 7200.0
"""The hull is mounted or taken off so often [s]."""

Bools = NDArray[np.bool_]
Stream = tuple[Array, Array]
Streams = dict[str, Stream]


@dataclass(frozen=True, slots=True)
class Voyage:
    """What the sensors of a vehicle say.

    Attributes:
        streams: name → (stamps [s], values).
        hull: time [s] → the hull's share of the damping.
    """

    streams: Streams
    hull: Callable[[float], float]


def experiment(seed: int, seconds: float, hull_at: float = np.inf) -> Voyage:
    """The paper's sinusoid, with the hull from `hull_at` [s] on."""
    rng = np.random.default_rng([seed, 1])
    t = _grid(seconds)
    command = 100.0 * np.sin(2.0 * np.pi * t / 67.0 + rng.uniform(0.0, 2.0 * np.pi))
    return _sailed(rng, t, command, t < 0.0, np.where(t >= hull_at, leng.HULL, 0.0), np.zeros(t.size))


def day(seed: int, seconds: float, sea: float = 3.0) -> Voyage:
    """Legs of turns, of held commands, of straight driving; the hull comes and goes, and so does a swell.

    Args:
        sea: standard deviation of the swell's moment at its highest [N m].
    """
    rng = np.random.default_rng([seed, 2])
    t = _grid(seconds)
    command, straight = np.zeros(t.size), np.zeros(t.size, dtype=bool)
    began, longest = 0.0, 0.5 * seconds
    while began < seconds:
        kind = rng.choice(["sine", "steps", "straight", "sweep"], p=[0.4, 0.3, 0.15, 0.15])
        length = rng.uniform(120.0, 900.0)
        if began >= longest and seconds >= 2.0 * HULL_PERIOD_S:
            kind, length, longest = "straight", MAX_STRAIGHT_S, np.inf
        here = (t >= began) & (t < began + length)
        straight[here] = kind == "straight"
        command[here] = _commanded(rng, kind, t[here] - began, length)
        began += length
    hull = np.where((t // HULL_PERIOD_S) % 2 == 1, leng.HULL, 0.0)
    return _sailed(rng, t, command, straight, hull, sea * _swell(rng, t))


def _grid(seconds: float) -> Array:
    return STEP_S * np.arange(round(seconds / STEP_S), dtype=np.float64)


def _commanded(rng: np.random.Generator, kind: str, t: Array, length: float) -> Array:
    """The torque [N m] of a leg at times from its beginning [s]; what holds the heading is not known before."""
    if kind == "sine":
        return np.asarray(rng.uniform(40.0, 100.0) * np.sin(2.0 * np.pi * t / rng.uniform(20.0, 90.0)))
    if kind == "sweep":
        return np.asarray(80.0 * np.sin(2.0 * np.pi * t * (0.01 + 0.03 * t / length)))
    if kind == "steps":
        number = np.cumsum(rng.random(t.size) < STEP_S / 15.0)
        return np.asarray(rng.choice([-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0], int(number[-1]) + 1)[number])
    return np.zeros(t.size)


def _sailed(rng: np.random.Generator, t: Array, command: Array, straight: Bools, hull: Array, water: Array) -> Voyage:
    rates, headings, torques = _motion(command, straight, hull, water)
    gyro, spin, compass = (_clock(rng, t[-1], period) for period in (GYRO_PERIOD_S, STEP_S, HEADING_PERIOD_S))
    load = (np.interp(gyro, t, torques) / 100.0) ** 2
    noise = np.hypot(GYRO_NOISE, VIBRATION * load)
    rate = np.interp(gyro, t, rates) + rng.normal(0.0, noise)
    torque = np.interp(spin, t, torques) + rng.normal(0.0, TORQUE_NOISE, spin.size)
    heading = np.interp(compass, t, headings) + rng.normal(0.0, HEADING_NOISE, compass.size)
    streams = {
        "yaw_rate": (gyro, rate.round(6)),
        "torque": (spin, torque.round(4)),
        "heading": (compass, ((heading + np.pi) % (2.0 * np.pi) - np.pi).round(5)),
    }
    return Voyage(streams, lambda at: float(hull[min(int(at / STEP_S), hull.size - 1)]))


def _motion(command: Array, straight: Bools, hull: Array, water: Array) -> tuple[Array, Array, Array]:
    """Yaw rate, heading and torque of the actuators, by the midpoint rule."""
    r = psi = wanted = 0.0
    rates, headings, torques = [], [], []
    held = False
    inertia, (by_heading, by_rate) = leng.INERTIA, HOLD_GAINS
    steps = zip(command.tolist(), straight.tolist(), (1.0 + hull).tolist(), water.tolist(), strict=True)
    for tau, hold, share, moment in steps:
        if hold:
            wanted = wanted if held else psi
            tau = max(-100.0, min(100.0, by_heading * (wanted - psi) - by_rate * r))
        held = hold
        rates.append(r)
        headings.append(psi)
        torques.append(tau)
        middle = r + 0.5 * STEP_S * (tau + moment - share * leng.damping(r)) / inertia
        r += STEP_S * (tau + moment - share * leng.damping(middle)) / inertia
        psi += STEP_S * middle
    return np.array(rates), np.array(headings), np.array(torques)


def _swell(rng: np.random.Generator, t: Array) -> Array:
    """Of standard deviation one at its highest: a dozen waves of 5 to 10 s, in groups, that come and go over hours."""
    waves = np.zeros(t.size)
    for _ in range(12):
        waves += np.sin(2.0 * np.pi * t / rng.uniform(5.0, 10.0) + rng.uniform(0.0, 2.0 * np.pi)) / np.sqrt(6.0)
    return np.asarray(waves * (0.5 - 0.5 * np.cos(2.0 * np.pi * t / 21_600.0 + rng.uniform(0.0, 2.0 * np.pi))))


def _clock(rng: np.random.Generator, seconds: float, period: float) -> Array:
    """Stamps of a sensor's own clock [s]: any phase, and some jitter."""
    stamps = np.arange(rng.uniform(0.0, period), seconds, period)
    return np.asarray((stamps + rng.uniform(0.0, 0.1 * period, stamps.size)).round(6))


def with_outliers(streams: Streams, share: float, rng: np.random.Generator) -> Streams:
    """A share of the values of yaw rate and torque is anywhere within twice their range."""
    everywhere = {name: np.ones(streams[name][0].size, dtype=bool) for name in ("yaw_rate", "torque")}
    return streams | {
        name: (streams[name][0], _wild(streams[name][1], here, share, rng)) for name, here in everywhere.items()
    }


def with_drop_outs(streams: Streams, a_minute: float, rng: np.random.Generator) -> Streams:
    """Each stream is silent now and then, for a second on average."""
    found = {}
    for name, (t, value) in streams.items():
        kept = np.ones(t.size, dtype=bool)
        for start in np.flatnonzero(rng.random(t.size) < a_minute / 60.0 * np.median(np.diff(t))):
            kept[start : int(np.searchsorted(t, t[start] + rng.exponential(1.0)))] = False
        found[name] = (t[kept], value[kept])
    return found


Change = Callable[[Array, Array, Bools, np.random.Generator], Stream]
"""(stamps, values, where they are at fault, rng) → the same at fault."""


def _frozen(value: Array, here: Bools) -> Array:
    return np.where(here, value[np.argmax(here)], value)


def _wild(value: Array, here: Bools, share: float, rng: np.random.Generator) -> Array:
    reach = 2.0 * float(np.quantile(np.abs(value), 0.99))
    wild = here & (rng.random(value.size) < share)
    return np.asarray(np.where(wild, rng.uniform(-reach, reach, value.size), value))


def _fast(t: Array, here: Bools) -> Array:
    return np.asarray(t + 0.005 * here * (t - t[np.argmax(here)]))


@dataclass(frozen=True, slots=True)
class Fault:
    """What goes wrong with one stream; `changes_vehicle` where no two streams tell it from a vehicle that changed."""

    stream: str
    change: Change
    changes_vehicle: bool = False

    def on(self, streams: Streams, since: float, until: float, rng: np.random.Generator) -> Streams:
        """The streams with the fault between two times [s]."""
        t, value = streams[self.stream]
        return streams | {self.stream: self.change(t, value, (t >= since) & (t < until), rng)}


NO_FAULT = Fault("torque", lambda t, v, here, rng: (t, v))
FAULTS: Mapping[str, Fault] = {
    "yaw rate's sign reversed": Fault("yaw_rate", lambda t, v, here, rng: (t, np.where(here, -v, v))),
    "torque's sign reversed": Fault("torque", lambda t, v, here, rng: (t, np.where(here, -v, v))),
    "torque frozen": Fault("torque", lambda t, v, here, rng: (t, _frozen(v, here))),
    "torque stuck at zero": Fault("torque", lambda t, v, here, rng: (t, np.where(here, 0.0, v))),
    "torque clipped at ±60 N m": Fault("torque", lambda t, v, here, rng: (t, np.where(here, np.clip(v, -60, 60), v))),
    "torque halved": Fault("torque", lambda t, v, here, rng: (t, np.where(here, 0.5 * v, v)), changes_vehicle=True),
    "a dead thruster": Fault("torque", lambda t, v, here, rng: (t, np.where(here, 2.0 * v, v)), changes_vehicle=True),
    "20 % outliers, torque": Fault("torque", lambda t, v, here, rng: (t, _wild(v, here, 0.2, rng))),
    "20 % outliers, gyro": Fault("yaw_rate", lambda t, v, here, rng: (t, _wild(v, here, 0.2, rng))),
    "gyro + 0.05 rad/s": Fault("yaw_rate", lambda t, v, here, rng: (t, v + 0.05 * here)),
    "gyro frozen": Fault("yaw_rate", lambda t, v, here, rng: (t, _frozen(v, here))),
    "gyro frozen, last bit toggles": Fault(
        "yaw_rate", lambda t, v, here, rng: (t, _frozen(v, here) + 1e-6 * here * rng.integers(0, 2, t.size))
    ),
    "gyro clipped at ±0.15 rad/s": Fault(
        "yaw_rate", lambda t, v, here, rng: (t, np.where(here, np.clip(v, -0.15, 0.15), v))
    ),
    "yaw rate in deg/s": Fault("yaw_rate", lambda t, v, here, rng: (t, np.where(here, np.rad2deg(v), v))),
    "torque's clock 0.5 % fast": Fault("torque", lambda t, v, here, rng: (_fast(t, here), v)),
    "gyro's clock 0.5 % fast": Fault("yaw_rate", lambda t, v, here, rng: (_fast(t, here), v)),
    "torque stamped 2 s late": Fault("torque", lambda t, v, here, rng: (t + 2.0 * here, v)),
    "gyro stamped 2 s late": Fault("yaw_rate", lambda t, v, here, rng: (t + 2.0 * here, v)),
}
