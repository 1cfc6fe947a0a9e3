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


def test_the_grid_is_the_papers() -> None:
    assert len(Grid()) == 64


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


def test_the_grid_of_a_faster_vehicle_gives_the_same_ranks() -> None:
    """Three times as fast and twice as damped: the same search in other units."""
    grid, samples = Grid(C=(10.0, 1000.0), epsilon=(0.1, 5.0), gamma=(10.0, 30.0)), stream(5, 200)
    other = Samples(samples.time, 3.0 * samples.yaw_rate, 2.0 * samples.damping)
    settings = replace(SETTINGS, policy="paper")
    units = {"near_rate": 0.03, "near_damping": 10.0, "rate_range": (-0.75, 0.75)}
    here = ranked(list(search(samples, settings, grid)), "every")
    there = ranked(list(search(other, replace(settings, **units), grid.scaled(3.0, 2.0))), "every")  # type: ignore[arg-type]
    np.testing.assert_allclose([trial.every for trial in there], [2.0 * trial.every for trial in here], rtol=1e-4)
    points = [(C / 2.0, epsilon / 2.0, 9.0 * gamma) for C, epsilon, gamma in (trial.point for trial in there)]
    np.testing.assert_allclose(points, [trial.point for trial in here])


def test_one_batch_cannot_be_left_out_of_one() -> None:
    with pytest.raises(BadInput, match="at least two"):
        next(search(stream(3, 99), SETTINGS))
