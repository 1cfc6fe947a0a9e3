"""How the noise follows the yaw rate."""

from __future__ import annotations

import json

import numpy as np

from incsvr.learning.learner import Settings
from incsvr.learning.spread import Spread
from tests.incsvr.learning import Policy, drag, policies, run, stream

FASTEST = 0.25


def tracked(seed: int, wild: float = 0.0) -> Spread:
    """After 40 batches of noise that is three times as loud at the fastest rate as at rest; its level is 4 N m."""
    rng, spread = np.random.default_rng(seed), Spread.start((-FASTEST, FASTEST))
    for _ in range(40):
        rate = rng.uniform(-FASTEST, FASTEST, 50)
        residual = 2.0 * (1.0 + 2.0 * np.abs(rate) / FASTEST) * rng.normal(size=50)
        residual = np.where(rng.random(50) < wild, 100.0, residual)
        spread = spread.after(rate, residual, 4.0)
    return spread


def test_louder_rates_are_found() -> None:
    at = np.array([0.0, 0.0625, 0.125, 0.25])
    found = np.mean([tracked(seed).at(at) for seed in range(10)], axis=0)
    true = 0.5 * (1.0 + 2.0 * at / FASTEST)
    np.testing.assert_allclose(found[1:3], true[1:3], rtol=0.05)
    # At the ends a knot has samples on one side alone, a third of the way to the next one.
    np.testing.assert_allclose(found[[0, 3]], true[[0, 3]] + np.array([1.0, -1.0]) / 12.0, rtol=0.08)
    np.testing.assert_array_equal(tracked(1).at(-at), tracked(1).at(at))


def test_outliers_hardly_move_it() -> None:
    at = np.array([0.0, 0.125, 0.25])
    np.testing.assert_allclose(tracked(2, wild=0.02).at(at), tracked(2).at(at), rtol=0.2)


def test_what_nobody_has_seen_is_as_loud_as_the_level() -> None:
    spread = Spread.start((-FASTEST, FASTEST)).after(np.zeros(50), np.full(50, 1.0), 4.0)
    assert spread.at(np.array([0.25]))[0] == 1.0
    assert spread.at(np.array([0.0]))[0] < 0.6
    assert Spread.from_dict(json.loads(json.dumps(spread.to_dict()))) == spread


@policies
def test_a_served_sigma_follows_the_rate(policy: Policy) -> None:
    samples = stream(21, 700, wild=0.0)
    noise = samples.damping - drag(samples.yaw_rate)
    samples.damping[:] = drag(samples.yaw_rate) + noise * (0.5 + 4.0 * np.abs(samples.yaw_rate))
    model = run(Settings(policy=policy), samples)[0].model
    quiet, loud = model.predict([0.02, 0.23]).sigma
    assert 1.6 < quiet < 3.5
    assert 4.5 < loud < 8.0
