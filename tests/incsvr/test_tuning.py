"""The grid search of Section IV-B."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.learning.tuning import Grid, ranked, search
from incsvr.signals.samples import Samples
from tests.incsvr.learning import run, stream

SETTINGS = Settings(policy="weighted")


@pytest.mark.parametrize("policy", ["paper", "weighted"])
def test_one_trial_by_hand(policy: str) -> None:
    samples = stream(1, 170)  # three batches and a rest that is not used
    grid = Grid(C=(1000.0,), epsilon=(1.0,), gamma=(20.0,))
    settings = replace(SETTINGS, C=1000.0, epsilon=1.0, gamma=20.0, policy=policy)  # type: ignore[arg-type]
    (trial,) = search(samples, settings, grid)
    errors = []  # (batch left out, training step)
    for left_out in range(3):
        rest = Samples.concatenate(samples.take(slice(50 * k, 50 * k + 50)) for k in range(3) if k != left_out)
        unseen = samples.take(slice(50 * left_out, 50 * left_out + 50))
        models = [iteration.model for iteration in run(settings, rest)[1]]
        errors.append([float(np.abs(model.evaluate(unseen.yaw_rate) - unseen.damping).mean()) for model in models])
    assert trial.settings == settings
    assert trial.every == pytest.approx(np.mean(errors), rel=1e-12)
    assert trial.last == pytest.approx(np.mean(errors, axis=0)[1], rel=1e-12)
    assert trial.spread == pytest.approx(
        (np.std(np.mean(errors, axis=1), ddof=1), np.std(errors, axis=0, ddof=1)[1]), rel=1e-12
    )


@pytest.mark.slow
def test_the_search_tells_a_good_point_from_bad_ones() -> None:
    grid = Grid(C=(0.1, 1000.0), epsilon=(0.1, 80.0), gamma=(10.0, 1e6))
    trials = list(search(stream(2, 250), SETTINGS, grid))
    assert len(trials) == len(grid)
    best, *_, worst = ranked(trials, "last")
    assert best.point == ranked(trials, "every")[0].point == (1000.0, 0.1, 10.0)
    assert best.last < 6.0 < 2.0 * best.last < worst.last


def test_one_batch_cannot_be_left_out_of_one() -> None:
    with pytest.raises(BadInput, match="at least two"):
        next(search(stream(3, 99), SETTINGS))
