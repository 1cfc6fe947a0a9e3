"""Whether a residual is white: as many false alarms as the level says, and few misses where something is missing."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.learning.learner import Settings, start, step
from incsvr.learning.whiteness import FEWEST, p_value
from incsvr.samples import Array, Samples
from incsvr.signals import SignalSettings, synchronise
from simulator.trial import Trial, play

PERIOD = 0.6
Turning = tuple[Array, Array, Array]


def turning(seed: int, count: int = 800) -> Turning:
    """Stamps, a yaw rate that changes within seconds, and what a learned curve left of outlier-ridden noise."""
    random = np.random.default_rng(seed)
    rate: Array = np.asarray(0.05 * np.convolve(random.normal(size=count + 5), np.ones(6), "valid"), dtype=np.float64)
    return PERIOD * np.arange(count, dtype=np.float64), rate, 30.0 * rate + random.standard_t(5.0, size=count)


def test_white_residuals_are_called_coloured_as_often_as_the_level_says() -> None:
    found = np.array([p_value(*turning(seed), PERIOD) for seed in range(1000)])
    for level, most in ((0.1, 0.13), (0.01, 0.022), (0.001, 0.005)):
        assert 0.3 * level < np.mean(found < level) < most


@pytest.mark.parametrize(
    "moment",
    [
        lambda t, rate: np.full(t.size, 0.8),
        lambda t, rate: 0.004 * (t - t.mean()),
        lambda t, rate: 1.5 * np.convolve(np.diff(rate, prepend=0.0), [1.0, 0.8, 0.6], "same") / np.std(rate),
    ],
    ids=["a constant moment", "a drift", "a moment that trails the motion"],
)
def test_what_is_missing_shows(moment: object) -> None:
    assert callable(moment)
    for seed in range(20):
        t, rate, residual = turning(seed)
        assert p_value(t, rate, residual + moment(t, rate), PERIOD) < 1e-3


def test_what_is_a_curve_over_the_rate_is_the_learners_own() -> None:
    found = []
    for seed in range(50):
        t, rate, residual = turning(seed)
        found.append(p_value(t, rate, residual + 5.0 * np.tanh(10.0 * rate), PERIOD))
    assert np.mean(np.array(found) < 0.01) < 0.1


def test_pauses_and_too_few_samples_are_no_alarm() -> None:
    t, rate, residual = turning(1)
    t = np.where(t > 200.0, t + 5000.0 * PERIOD, t)
    assert p_value(t, rate, residual, PERIOD) > 1e-3
    few = slice(0, FEWEST - 1)
    assert p_value(t[few], rate[few], residual[few] + 100.0, PERIOD) == 1.0
    assert p_value(t, 0.0 * rate, residual, PERIOD) == 1.0
    assert p_value(t, rate, 0.0 * residual, PERIOD) == 1.0


@pytest.mark.parametrize(("effects", "white"), [((), True), (("torque_lag",), False), (("bias_torque",), False)])
def test_a_learner_notices_what_is_hidden_in_its_vehicle(effects: tuple[str, ...], white: bool) -> None:
    for seed in (1, 2, 3):
        played = play(Trial(seed, effects, duration=420.0))
        streams = {name: played.recording.streams()[name] for name in ("yaw_rate", "torque")}
        samples, _ = synchronise(SignalSettings(inertia=played.inertia), streams)
        p = p_value(samples.time, samples.yaw_rate, left_by_the_learner(samples), PERIOD)
        assert (p > 1e-3) == white, (seed, p)


def left_by_the_learner(samples: Samples) -> Array:
    """(n,) the residual of the model that is served in the end [N m]."""
    settings = Settings(rate_range=(-0.35, 0.35))
    state = start(settings)
    for first in range(0, len(samples) - 49, 50):
        state, _ = step(settings, state, samples.take(slice(first, first + 50)))
    served = state.model.predict(samples.yaw_rate).damping - state.model.predict(np.zeros(1)).damping
    return np.asarray(samples.damping - served)
