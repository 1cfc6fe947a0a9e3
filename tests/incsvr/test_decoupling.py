"""Whether an axis is by itself: told where another velocity takes much of its torque, and not where nothing does."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from incsvr.checks.decoupling import NeglectedTerms, neglected_terms
from incsvr.numerics import Array
from incsvr.plant.axes import AXES

COUNT = 400
RATE, DRAG = 0.2, 50.0


def wandering(random: np.random.Generator, level: float) -> Array:
    """Correlated at 0.9 from sample to sample."""
    values = np.asarray(lfilter([1.0], [1.0, -0.9], random.normal(0.0, 1.0, COUNT)), dtype=np.float64)
    return level * values / np.std(values)


def found(seed: int, munk: float, sway_inertia: float = 0.0) -> NeglectedTerms | None:
    """Of a yaw with drag, noise of a tenth, and a moment `munk` u v + `sway_inertia` v̇."""
    random = np.random.default_rng(seed)
    rate, surge, sway = wandering(random, RATE), wandering(random, 0.5), wandering(random, 0.2)
    slope = np.gradient(sway)
    damping = DRAG * rate + munk * surge * sway + sway_inertia * slope + wandering(random, 0.1 * DRAG * RATE)
    torque = damping + 20.0 * np.gradient(rate)
    return neglected_terms(
        AXES["yaw"], rate, damping, torque, {"surge": (surge, np.gradient(surge)), "sway": (sway, slope)}
    )


def test_an_inertia_that_couples_is_told() -> None:
    told = found(900_401, munk=0.0, sway_inertia=100.0)
    assert told is not None
    assert told.terms == ("the change of channel sway",)


def test_what_is_small_or_not_there_is_not_told() -> None:
    assert all(found(seed, munk=0.0) is None for seed in range(900_410, 900_440))
    assert found(900_402, munk=6.0) is None


def test_unknown_velocities_and_few_samples_say_nothing() -> None:
    nothing = np.full(COUNT, np.nan)
    rate = wandering(np.random.default_rng(900_403), RATE)
    assert (
        neglected_terms(AXES["yaw"], rate, rate, rate, {"surge": (nothing, nothing), "sway": (nothing, nothing)})
        is None
    )
    assert neglected_terms(AXES["yaw"], rate, rate, rate, {}) is None
