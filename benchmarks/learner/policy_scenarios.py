"""What can happen to a learner, as streams of damping samples whose true curve is known at every moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.samples import Samples
from simulator import leng

SAMPLE_PERIOD_S = 0.6
"""Between two samples [s], as in the Leng experiment."""
NOISE_NM = 4.0
"""Noise of a sample [N m]."""
RATES: Array = np.linspace(-0.24, 0.24, 97)
"""Where a learner is judged [rad/s]."""
SAMPLES_BEFORE = 700
"""Samples before anything happens, as many as T1 has."""

Factor = Callable[[Array, Array], Array]


@dataclass(frozen=True, slots=True)
class Scenario:
    """A stream and its truth.

    Attributes:
        sentence: what happens.
        samples: how many.
        event: the sample at which it happens: from that batch on a learner is judged.
        amplitude: (n,) of the sinusoidal yaw rate at each sample [rad/s].
        correlation: of two consecutive samples' noise.
        outliers: part of the samples that lie 20 to 60 N m off.
        factor: (rates, sample numbers) → by what the vehicle's damping is multiplied.
        offset: (sample numbers) → moment that comes on top [N m].
        disturbance: (sample numbers) → moment in the samples that is not the vehicle's damping [N m].
        inertia_error: by what the declared inertia is wrong [kg m²]: its share of I ṙ stays in the samples.
    """

    sentence: str
    samples: int = SAMPLES_BEFORE + 550
    event: int = SAMPLES_BEFORE
    amplitude: Callable[[Array], Array] = lambda k: np.full(k.size, 0.24)
    correlation: float = 0.0
    outliers: float = 0.01
    factor: Factor = lambda r, k: np.ones(np.broadcast(r, k).shape)
    offset: Callable[[Array], Array] = lambda k: np.zeros(k.size)
    disturbance: Callable[[Array], Array] = lambda k: np.zeros(k.size)
    inertia_error: float = 0.0

    def truth(self, sample: int) -> Array:
        """d(RATES) [N m] when `sample` samples have been taken."""
        at = np.array([sample - 1.0])
        return leng.damping(RATES) * self.factor(RATES, at) + self.offset(at)

    def draw(self, seed: int) -> Samples:
        """The stream; its rates carry the gyro's noise after smoothing, 0.0015 rad/s."""
        rng = np.random.default_rng([seed, *self.sentence.encode()])
        k: Array = np.arange(self.samples, dtype=np.float64)
        rate = self.amplitude(k) * np.sin(2.0 * np.pi * k * SAMPLE_PERIOD_S / 67.0 + rng.uniform(0.0, 2.0 * np.pi))
        noise = rng.normal(size=k.size)
        for i in range(1, k.size if self.correlation else 0):
            noise[i] = self.correlation * noise[i - 1] + np.sqrt(1.0 - self.correlation**2) * noise[i]
        damping = leng.damping(rate) * self.factor(rate, k) + self.offset(k) + self.disturbance(k) + NOISE_NM * noise
        damping += self.inertia_error * np.gradient(rate, SAMPLE_PERIOD_S)
        wild = rng.random(k.size) < self.outliers
        damping += wild * rng.choice([-1.0, 1.0], k.size) * rng.uniform(20.0, 60.0, k.size)
        return Samples(k * SAMPLE_PERIOD_S, rate + 0.0015 * rng.normal(size=k.size), damping)


def _step(part: float, at: int = SAMPLES_BEFORE) -> Factor:
    return lambda r, k: 1.0 + part * (k >= at) * np.ones(np.shape(r))


def _one_side(r: Array, k: Array) -> Array:
    return np.asarray(1.0 + 0.15 * (k >= SAMPLES_BEFORE) * (r > 0.0))


def _bump(r: Array, k: Array) -> Array:
    return np.asarray(1.0 + 0.25 * (k >= SAMPLES_BEFORE) * np.exp(-(((r - 0.12) / 0.03) ** 2)))


def _offset(k: Array) -> Array:
    return np.where(k >= SAMPLES_BEFORE, 6.0, 0.0)


def _burst(k: Array) -> Array:
    return np.where((k >= SAMPLES_BEFORE + 5) & (k < SAMPLES_BEFORE + 35), 25.0, 0.0)


def _drift(r: Array, k: Array) -> Array:
    return 1.0 + 0.5 * np.maximum(k - 500.0, 0.0) / 2000.0 * np.ones(np.shape(r))


SCENARIOS: Mapping[str, Scenario] = {
    "hull on": Scenario("the hull adds 11.5 %", factor=_step(leng.HULL)),
    "hull off": Scenario("the hull's 11.5 % go", factor=_step(-leng.HULL)),
    "outliers": Scenario("20 % outliers, and the hull", outliers=0.2, factor=_step(leng.HULL)),
    "correlated": Scenario("noise correlated at 0.8, and the hull", correlation=0.8, factor=_step(leng.HULL)),
    "correlated at 0.95": Scenario("noise correlated at 0.95, and the hull", correlation=0.95, factor=_step(leng.HULL)),
    "bump": Scenario("+25 % within 0.03 rad/s of 0.12 rad/s alone", factor=_bump),
    "hull at low speed": Scenario(
        "the hull, met at |r| ≤ 0.06 rad/s alone, judged over all rates",
        amplitude=lambda k: np.where(k < SAMPLES_BEFORE, 0.24, 0.06),
        factor=_step(leng.HULL),
    ),
    "low speed": Scenario(
        "1,000 samples at |r| ≤ 0.06 rad/s, judged over all rates",
        samples=SAMPLES_BEFORE + 1000,
        amplitude=lambda k: np.where(k < SAMPLES_BEFORE, 0.24, 0.06),
    ),
    "drift": Scenario("+50 % over 2,000 samples", samples=2500, event=500, factor=_drift),
    "one side": Scenario("+15 % at positive rates alone", factor=_one_side),
    "offset": Scenario("6 N m come on top", offset=_offset),
    "burst": Scenario(
        "30 samples are 25 N m off, then all is as before",
        disturbance=_burst,
    ),
    "wrong inertia": Scenario(
        "the inertia is declared 300 kg m² wrong, the amplitude changes every 150 samples",
        samples=2000,
        event=200,
        amplitude=lambda k: np.array([0.24, 0.08, 0.16, 0.2, 0.06])[(k // 150).astype(int) % 5],
        inertia_error=300.0,
    ),
    "nothing": Scenario("5,000 samples, nothing happens", samples=5000, event=200),
    "nothing, correlated": Scenario(
        "5,000 samples, noise correlated at 0.8, nothing happens", samples=5000, event=200, correlation=0.8
    ),
}
