"""The weighted policy: what it is there for."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.learning.dual import solve
from incsvr.learning.learner import Settings, start, step
from incsvr.signals.samples import Samples
from tests.incsvr.learning import HULL, batches, drag, rms, run, stream

WEIGHTED = Settings(policy="weighted")
RATES = np.linspace(-0.24, 0.24, 49)


def errors(settings: Settings, samples: Samples, factors: list[float]) -> list[float]:
    """RMS to the truth after each batch [N m]."""
    _, iterations = run(settings, samples)
    return [
        rms(iteration.model.evaluate(RATES) - factor * drag(RATES))
        for iteration, factor in zip(iterations, factors, strict=True)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_it_is_as_good_as_an_offline_regression_on_all_samples(seed: int) -> None:
    samples = stream(100 + seed, 700)
    offline = solve(samples.yaw_rate, samples.damping, gamma=10.0, C=1000.0, epsilon=0.1)
    curve = np.exp(-10.0 * np.subtract.outer(RATES, samples.yaw_rate) ** 2) @ offline.weight
    state, _ = run(WEIGHTED, samples)
    unseen = stream(200 + seed, 500)
    at = np.interp(unseen.yaw_rate, RATES, curve)
    reference = float(np.abs(at - unseen.damping).mean())
    ours = float(np.abs(state.model.evaluate(unseen.yaw_rate) - unseen.damping).mean())
    assert state.model.weight.size <= 60
    assert ours < 1.03 * reference


@pytest.mark.parametrize("seed", range(5))
def test_the_hull_is_noticed_and_learned_within_four_batches(seed: int) -> None:
    samples = stream(300 + seed, 1250, hull_from=700)
    _, iterations = run(WEIGHTED, samples)
    noticed = [iteration.number for iteration in iterations if iteration.change]
    assert noticed
    assert 15 <= noticed[0] <= 17  # the hull comes with batch 15
    error = errors(WEIGHTED, samples, [1.0] * 14 + [1.0 + HULL] * 11)
    noise = 4.0
    # The error on fresh samples, √(noise² + error²), is within 3 % of its final value.
    assert np.hypot(noise, error[17]) < 1.03 * np.hypot(noise, error[-1])


@pytest.mark.slow
def test_nothing_is_noticed_where_nothing_happens() -> None:
    for seed in range(3):
        _, iterations = run(WEIGHTED, stream(400 + seed, 2500))
        assert [iteration.change for iteration in iterations] == [None] * 50


def test_what_was_forgotten_is_still_known() -> None:
    """A long stay at low speed takes from the paper's vectors, not from these."""
    fast, slow = stream(500, 700), stream(501, 1500)
    slow = Samples(
        slow.time + 420.0, 0.25 * slow.yaw_rate, slow.damping - drag(slow.yaw_rate) + drag(0.25 * slow.yaw_rate)
    )
    samples = Samples.concatenate([fast, slow])
    count = len(samples) // 50
    assert errors(WEIGHTED, samples, [1.0] * count)[-1] < 1.0


def test_a_burst_is_taken_back() -> None:
    samples = stream(600, 1100)
    samples.damping[705:735] += 25.0
    _, iterations = run(WEIGHTED, samples)
    said = [iteration.change for iteration in iterations if iteration.change]
    assert any("as it was before" in sentence for sentence in said)
    assert rms(iterations[-1].model.evaluate(RATES) - drag(RATES)) < 1.2


def test_the_constants_follow_the_vehicle() -> None:
    """Seven times as fast, a sixteenth of the moment: the same vehicle in other units, the same curve in its own."""
    speed, moment = 7.2, 1.0 / 16.0
    small = Settings(
        policy="weighted",
        gamma=10.0 / speed**2,
        C=1000.0 * moment,
        epsilon=0.1 * moment,
        near_rate=0.01 * speed,
        near_damping=5.0 * moment,
        rate_range=(-0.25 * speed, 0.25 * speed),
    )
    here, there = start(WEIGHTED), start(small)
    for batch in batches(stream(800, 1250, hull_from=700)):
        here, said = step(WEIGHTED, here, batch)
        scaled = Samples(batch.time, speed * batch.yaw_rate, moment * batch.damping)
        there, heard = step(small, there, scaled)
        assert len(heard.outliers) == len(said.outliers)
        assert (heard.change is None) == (said.change is None)
        np.testing.assert_allclose(
            there.model.evaluate(speed * RATES), moment * here.model.evaluate(RATES), atol=0.02 * moment
        )


def test_a_correction_is_not_trusted_beyond_the_rates_that_showed_it() -> None:
    before, _ = run(WEIGHTED, stream(1, 700))
    rng = np.random.default_rng(4)
    rate = rng.uniform(-0.12, 0.12, 50)
    batch = Samples(500.0 + np.linspace(0.0, 29.4, 50), rate, 1.6 * drag(rate) + 4.0 * rng.normal(size=50))
    after, iteration = step(WEIGHTED, before, batch)
    assert iteration.change is not None
    beyond = np.linspace(0.16, 0.24, 9)
    moved = after.model.evaluate(beyond) - before.model.evaluate(beyond)
    assert np.ptp(moved) < 5.0  # where a gain alone would have added 27 N m on the way
    assert 10.0 < moved.mean() < 30.0
