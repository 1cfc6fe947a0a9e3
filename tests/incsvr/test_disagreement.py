"""Fresh samples that disagree with what was served widen its own doubt."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.learning.disagreement import Disagreement
from incsvr.learning.learner import Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.signals.samples import Samples
from tests.incsvr.learning import drag, run, stream


@pytest.fixture(scope="module")
def model() -> Model:
    return run(Settings(policy="weighted"), stream(31, 700))[0].model


def _samples(rate: Array, damping: Array) -> Samples:
    return Samples(np.arange(rate.size, dtype=np.float64), rate, damping)


def with_batch(found: Disagreement, model: Model, samples: Samples) -> Disagreement:
    return found.after(model, samples, model.at(samples), 0.25)


def after(model: Model, error: float, batches: int = 20, seed: int = 1) -> Disagreement:
    """Batches of which each is off by one moment of this deviation [N m], beside noise of 4 N m."""
    rng, found = np.random.default_rng(seed), Disagreement()
    for _ in range(batches):
        rate: Array = rng.uniform(-0.24, 0.24, 50)
        damping = drag(rate) + 4.0 * rng.normal(size=50) + error * rng.normal()
        found = with_batch(found, model, _samples(rate, damping))
    return found


def test_a_curve_that_fresh_samples_confirm_keeps_its_doubt(model: Model) -> None:
    assert np.mean([after(model, 0.0, seed=seed).widening for seed in range(10)]) < 1.25


def test_the_doubt_becomes_as_wide_as_the_error_that_shows(model: Model) -> None:
    claimed = float(model.predict([0.1]).doubt[0]) / model.widening
    widths = [claimed * after(model, 6.0, seed=seed).widening for seed in range(10)]
    assert np.mean(widths) == pytest.approx(6.0, rel=0.25)


def test_few_samples_and_rates_that_were_never_learned_say_nothing(model: Model) -> None:
    nothing = Disagreement()
    assert with_batch(nothing, model, _samples(np.full(50, 0.6), np.zeros(50))) == nothing
    assert with_batch(nothing, model, _samples(np.array([0.1, 0.1]), np.array([500.0, 500.0]))) == nothing
