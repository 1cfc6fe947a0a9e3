"""What is served: the columns against the sum, doubt, extrapolation and what lies beyond."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from incsvr.errors import BadInput
from incsvr.learning.dual import solve
from incsvr.learning.kernel import rbf
from incsvr.learning.learner import Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.numerics.linear_filter import lfilter
from tests.incsvr.learning import drag, run, stream


def model_of(rate: Array, damping: Array, *, gamma: float = 10.0, sigma: float = 4.0, count: float = 1.0) -> Model:
    weight = solve(rate, damping, gamma=gamma, C=1000.0, epsilon=0.1).weight
    return Model(gamma, 1000.0, 0.1, rate, damping, weight, np.full(rate.size, count), sigma, 0.0)


@pytest.fixture(scope="module")
def learned() -> Model:
    return run(Settings(policy="weighted"), stream(1, 1000))[0].model


@given(st.integers(1, 40), st.floats(0.1, 1000.0), st.integers(0, 1000))
def test_the_curve_is_the_sum_for_any_model(n: int, gamma: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate = rng.uniform(-0.25, 0.25, n)
    model = model_of(rate, drag(rate) + 4.0 * rng.normal(size=n), gamma=gamma)
    at = np.append(rng.uniform(rate.min(), rate.max(), 50), [rate.min(), rate.max()])
    bare = model.evaluate(at)
    np.testing.assert_allclose(model.predict(at).damping, bare, atol=1e-6 * np.abs(bare).max())


@pytest.mark.parametrize("gamma", [30.0, 900.0])
def test_one_rate_and_many_give_the_same(gamma: float) -> None:
    """A gap is among them, and a kernel whose series has too many terms."""
    rate = np.append(np.linspace(-0.25, -0.02, 20), 0.2)
    model = model_of(rate, drag(rate), gamma=gamma)
    rates = np.linspace(-0.4, 0.4, 81)
    many = model.predict(rates)
    assert many.extrapolated[(rates > -0.02) & (rates < 0.2)].any()
    for k, rate_k in enumerate(rates.tolist()):
        one = model.predict(rate_k)
        for name in ("damping", "sigma", "noise", "doubt", "derivative"):
            assert getattr(one, name)[0] == pytest.approx(getattr(many, name)[k], rel=1e-9, abs=1e-9)
        assert one.extrapolated[0] == many.extrapolated[k]


def test_the_doubt_is_that_of_the_gaussian_process(learned: Model) -> None:
    """Beside K + D whole, as the textbook has it."""
    x, rates = learned.support_rate, np.linspace(*(learned.trained_range or (0.0, 0.0)), 50)
    scale = np.abs(learned.support_damping).max()
    noise = learned.sigma * learned.spread.at(x)
    worth = (1.0 - learned.correlation) / (1.0 + learned.correlation) * 2.0 / np.pi / 1.7
    whole, cross = (scale**2 * rbf(each, x, learned.gamma) for each in (x, rates))
    explained = np.sum(cross * np.linalg.solve(whole + np.diag(noise**2 / (worth * learned.count)), cross.T).T, axis=1)
    known = np.sqrt(scale**2 - explained + (0.35 * learned.sigma * learned.spread.at(rates)) ** 2)
    assert learned.water.moment == 0.0
    np.testing.assert_allclose(learned.predict(rates).doubt, known, rtol=1e-6)


@pytest.mark.parametrize("low", [-0.25, 0.05])
def test_the_derivative_is_that_of_the_curve_inside_and_outside(low: float) -> None:
    rate = np.linspace(low, 0.25, 40)
    model = model_of(rate, drag(rate), gamma=30.0)
    at = np.linspace(-0.6, 0.6, 242)  # not at rest, where a curve that never came there may have an edge
    step = 1e-6
    by_differences = (model.predict(at + step).damping - model.predict(at - step).damping) / (2.0 * step)
    np.testing.assert_allclose(model.predict(at).derivative, by_differences, rtol=1e-4, atol=1e-2)
    inside = at[(at > low) & (at < 0.25)]
    apart = np.subtract.outer(inside, rate)
    analytic = (-2.0 * 30.0 * apart * np.exp(-30.0 * apart**2)) @ model.weight
    np.testing.assert_allclose(model.predict(inside).derivative, analytic, atol=1e-3)


def test_fresh_samples_scatter_as_sigma_says() -> None:
    scores = []
    for seed in range(8):
        model = run(Settings(policy="weighted"), stream(40 + seed, 700, wild=0.0))[0].model
        fresh = stream(90 + seed, 700, wild=0.0)
        said = model.predict(fresh.yaw_rate)
        scores.append((fresh.damping - said.damping) / said.sigma)
    score = np.concatenate(scores)
    assert score.std() == pytest.approx(1.0, abs=0.08)
    assert np.mean(np.abs(score) < 1.96) == pytest.approx(0.95, abs=0.02)


def test_the_band_of_95_percent_holds_the_truth_where_the_noise_lasts() -> None:
    """And it is not so wide that it says nothing."""
    rates, scores = np.linspace(-0.23, 0.23, 47), []
    for seed in range(6):
        quiet = stream(70 + seed, 500, sigma=0.0, wild=0.0)
        noise = 4.0 * 0.6 * lfilter([1.0], [1.0, -0.8], np.random.default_rng(seed).normal(size=500))
        model = run(Settings(policy="weighted"), replace(quiet, damping=quiet.damping + noise))[0].model
        said = model.predict(rates)
        scores.append((said.damping - drag(rates)) / said.doubt)
    score = np.concatenate(scores)
    assert np.mean(np.abs(score) < 1.96) >= 0.95
    assert score.std() > 0.5


def test_doubt_grows_where_data_are_thin() -> None:
    rng = np.random.default_rng(5)
    rate = np.concatenate((np.linspace(-0.25, -0.2, 30), np.linspace(0.0, 0.25, 30)))
    model = model_of(rate, drag(rate) + 4.0 * rng.normal(size=60), gamma=60.0)
    dense, thin, outside, far = model.predict([0.12, -0.1, 0.3, 0.6]).sigma
    assert 4.0 < dense < 5.0
    assert thin > 2.0 * dense
    assert dense < outside < far
    more = model_of(rate, model.support_damping, gamma=60.0, count=10.0)
    assert more.predict(0.12).sigma[0] < dense


def test_a_gap_between_vectors_is_extrapolated_too() -> None:
    rate = np.concatenate((np.linspace(-0.25, -0.15, 20), np.linspace(0.1, 0.25, 20)))
    model = model_of(rate, drag(rate), gamma=200.0)
    assert model.predict([-0.3, -0.2, 0.0, 0.2, 0.3]).extrapolated.tolist() == [True, False, True, False, True]


def test_beyond_the_learned_rates_it_goes_on_as_drag_does(learned: Model) -> None:
    low, high = learned.trained_range or (0.0, 0.0)
    rate = np.linspace(high, 1.0, 400)
    for sign, edge in ((1.0, high), (-1.0, -low)):
        outward = np.linspace(edge, 1.0, 400)
        said = learned.predict(sign * outward)
        assert (sign * said.damping > 0.0).all()  # dissipative
        assert (np.diff(sign * said.damping) > 0.0).all()  # grows
        assert said.extrapolated[1:].all()
        assert abs(said.damping[0] - learned.evaluate(np.array([sign * edge]))[0]) < 1e-5  # continuous
    assert learned.predict(0.4).damping[0] == pytest.approx(float(drag(np.array([0.4]))[0]), rel=0.05)
    # What the bare sum does there is the reason for all this.
    assert learned.evaluate(rate)[-1] < 0.5 * drag(rate)[-1]


def test_where_only_one_side_was_learned_the_other_is_its_mirror() -> None:
    rng = np.random.default_rng(6)
    rate = np.linspace(0.05, 0.25, 60)
    model = model_of(rate, drag(rate) + rng.normal(size=60), sigma=1.0)
    at = np.linspace(-0.25, 0.05, 301)
    said = model.predict(at)
    assert said.extrapolated[:-1].all()
    assert (said.damping * at >= 0.0).all()
    assert np.abs(np.diff(said.damping)).max() < 2.0  # continuous, through zero at rest
    assert said.damping[np.abs(at).argmin()] == pytest.approx(0.0, abs=0.05)
    assert said.damping[0] == pytest.approx(float(-drag(np.array([0.25]))[0]), rel=0.1)


def test_drag_is_never_negative_however_the_data_slope() -> None:
    rate, outward = np.linspace(-0.2, 0.2, 41), np.linspace(0.201, 1.0, 50)
    for damping in (-100.0 * rate, 300.0 * rate - 1000.0 * rate * np.abs(rate), np.full(41, 5.0), np.zeros(41)):
        beyond = model_of(rate, damping).predict(outward).damping
        assert (np.diff(beyond) >= 0.0).all()


def test_a_model_survives_a_file_to_the_bit(learned: Model) -> None:
    back = Model.from_dict(json.loads(json.dumps(learned.to_dict())))
    rates = np.linspace(-0.5, 0.5, 101)
    np.testing.assert_array_equal(back.predict(rates).damping, learned.predict(rates).damping)
    np.testing.assert_array_equal(back.predict(rates).sigma, learned.predict(rates).sigma)
    untrained = Model.from_dict(json.loads(json.dumps(Model.untrained(10.0, 1000.0, 0.1).to_dict())))
    assert not untrained.is_trained
    assert untrained.trained_range is None


def test_questions_that_cannot_be_answered_are_refused(learned: Model) -> None:
    with pytest.raises(BadInput, match="nothing is learned yet"):
        Model.untrained(10.0, 1000.0, 0.1).predict(0.1)
    for rate in (float("nan"), float("inf"), -float("inf")):
        with pytest.raises(BadInput, match="not finite"):
            learned.predict([0.1, rate])
    assert learned.predict(np.empty(0)).damping.size == 0
