"""Streams for the learner's tests: a sinusoidal yaw rate, drag, noise, and a hull that comes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from incsvr.learning.learner import Iteration, Settings, State, start, step
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

HULL = 0.12


def drag(rate: Array) -> Array:
    """The truth [N m]: linear and quadratic drag."""
    return np.asarray(110.0 * rate + 1150.0 * rate * np.abs(rate))


def stream(seed: int, n: int, *, hull_from: int | None = None, sigma: float = 4.0, wild: float = 0.01) -> Samples:
    """n samples 0.6 s apart at |r| ≤ 0.24 rad/s; from sample `hull_from` on the damping is HULL larger."""
    rng = np.random.default_rng(seed)
    k = np.arange(n, dtype=np.float64)
    rate = 0.24 * np.sin(2.0 * np.pi * k * 0.6 / 67.0 + rng.uniform(0.0, 6.28))
    factor = 1.0 + HULL * (k >= (n if hull_from is None else hull_from))
    damping = drag(rate) * factor + sigma * rng.normal(size=n)
    damping += (rng.random(n) < wild) * rng.choice([-1.0, 1.0], n) * rng.uniform(20.0, 60.0, n)
    return Samples(0.6 * k, rate, damping)


def batches(samples: Samples, size: int = 50) -> Iterator[Samples]:
    for first in range(0, len(samples) - size + 1, size):
        yield samples.take(slice(first, first + size))


def run(settings: Settings, samples: Samples) -> tuple[State, list[Iteration]]:
    state, iterations = start(settings), []
    for batch in batches(samples, settings.batch):
        state, iteration = step(settings, state, batch)
        iterations.append(iteration)
    return state, iterations


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
