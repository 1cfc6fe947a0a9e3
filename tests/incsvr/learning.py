"""Streams for the learner's tests: a sinusoidal yaw rate, drag, noise, and a hull that comes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from incsvr.learning.learner import Iteration, Settings, State, start, step
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

HULL = 0.12
OTHERS = ("sway", "surge")
MUNK = 300.0
"""Moment of surge times sway [N m s²/m²]."""
Policy = Literal["paper", "weighted"]
POLICIES: tuple[Policy, ...] = ("paper", "weighted")
policies = pytest.mark.parametrize("policy", POLICIES)
kinds = pytest.mark.parametrize(
    "settings",
    [Settings(policy="paper"), Settings(policy="weighted"), Settings(policy="weighted", others=OTHERS)],
    ids=["paper", "weighted", "weighted-several"],
)
"""Both policies over one velocity, and that over several: what holds of a learner holds of these three."""


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


def among_others(samples: Samples) -> Samples:
    """The same beside a surge and a sway, whose product turns the vehicle, too."""
    surge, sway = 0.6 + 0.3 * np.sin(samples.time / 23.0), 0.2 * np.sin(samples.time / 9.0 + 1.0)
    return replace(samples, damping=samples.damping + MUNK * surge * sway, channels={"surge": surge, "sway": sway})


def of(settings: Settings, samples: Samples) -> Samples:
    """The samples that these settings learn of: over several velocities among others."""
    return among_others(samples) if settings.others else samples


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
