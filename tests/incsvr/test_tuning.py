"""The grid search of Section IV-B."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.learning.tuning import Grid, best, search
from incsvr.samples import Samples
from tests.incsvr.learning import run, stream

SETTINGS = Settings(policy="weighted")


def test_the_grid_is_the_papers() -> None:
    assert len(Grid()) == 64


def test_one_trial_by_hand() -> None:
    samples = stream(1, 170)  # three batches and a rest that is not used
    grid = Grid(C=(1000.0,), epsilon=(1.0,), gamma=(20.0,))
    (trial,) = search(samples, SETTINGS, grid)
    settings = replace(SETTINGS, C=1000.0, epsilon=1.0, gamma=20.0)
    errors = []
    for left_out in range(3):
        rest = Samples.concatenate(samples.take(slice(50 * k, 50 * k + 50)) for k in range(3) if k != left_out)
        unseen = samples.take(slice(50 * left_out, 50 * left_out + 50))
        model = run(settings, rest)[0].model
        errors.append(float(np.abs(model.evaluate(unseen.yaw_rate) - unseen.damping).mean()))
    assert trial.settings == settings
    assert trial.mae == pytest.approx(np.mean(errors), rel=1e-12)
    assert trial.spread == pytest.approx(np.std(errors, ddof=1), rel=1e-12)


def test_the_search_tells_a_good_point_from_bad_ones() -> None:
    grid = Grid(C=(0.1, 1000.0), epsilon=(0.1, 80.0), gamma=(10.0, 1e6))
    trials = list(search(stream(2, 400), SETTINGS, grid))
    assert len(trials) == len(grid)
    chosen = best(trials)
    assert (chosen.settings.C, chosen.settings.epsilon, chosen.settings.gamma) == (1000.0, 0.1, 10.0)
    assert chosen.mae < 6.0 < 2.0 * chosen.mae < max(trial.mae for trial in trials)


def test_one_batch_cannot_be_left_out_of_one() -> None:
    with pytest.raises(BadInput, match="at least two"):
        next(search(stream(3, 99), SETTINGS))
