"""p-values, intervals and the bootstrap of a change, against what they promise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import catalogue
from incsvr.tracing.run import Array
from incsvr.tracing.statistics import change_of_rms, p_value, rms
from incsvr.tracing.weak.evidence import evidence, gain_of
from incsvr.tracing.weak.hypothesis import nothing, settle
from incsvr.tracing.weak.validation_errors import sample_errors
from tests.incsvr.turning import PERIOD, command, instants, turning


def errors(seed: int, scale: float) -> Array:
    coloured: Array = lfilter([1.0], [1.0, -0.95], np.random.default_rng(seed).normal(0.0, scale, 3000))
    return coloured


def test_a_p_value_pays_for_every_look() -> None:
    assert p_value(10.83, 1, 1.0) == pytest.approx(1e-3, rel=0.01)
    assert p_value(10.83, 1, 50.0) == pytest.approx(0.05, rel=0.01)
    assert p_value(0.0, 2, 1.0) == 1.0
    assert p_value(-3.0, 1, 100.0) == 1.0


def test_a_change_of_nothing_has_zero_inside_its_interval() -> None:
    """Paired errors of equal size and long memory: the interval must not be fooled by their autocorrelation."""
    covered = 0
    for seed in range(40):
        change = change_of_rms([errors(seed, 1.0)], [errors(1000 + seed, 1.0)], 200)
        covered += change.low <= 0.0 <= change.high
    assert covered >= 34  # of 40, promised are 38


def test_a_real_change_excludes_zero_and_its_estimate_is_the_difference() -> None:
    before, after = [errors(1, 1.0), errors(2, 1.0)], [errors(3, 0.5), errors(4, 0.5)]
    change = change_of_rms(before, after, 200)
    assert change.estimate == pytest.approx(rms(after) - rms(before))
    assert change.low < change.estimate < change.high < 0.0


def test_the_same_errors_change_by_exactly_nothing() -> None:
    change = change_of_rms([errors(1, 1.0)], [errors(1, 1.0)], 100)
    assert (change.low, change.estimate, change.high) == (0.0, 0.0, 0.0)


def test_errors_of_single_samples_hold_the_scatter_within_a_block() -> None:
    random = np.random.default_rng(7)
    block = random.normal(0.0, 2.0, 200_000)
    mae, rmse = sample_errors([block], 3.0)
    sampled = block + random.normal(0.0, 3.0, block.size)
    assert rmse == pytest.approx(float(np.std(sampled)), rel=0.01)
    assert mae == pytest.approx(float(np.mean(np.abs(sampled))), rel=0.01)


TIME = instants(400.0)


def narrow(seed: int, k: int, period: float) -> Array:
    """Noise of deviation one within a few per cent of a period [s]."""
    kept, turn = 0.996, 2.0 * np.pi * PERIOD / period
    noise = np.random.default_rng([seed, k]).normal(size=TIME.size + 4000)
    band: Array = lfilter([1.0], [1.0, -2.0 * kept * np.cos(turn), kept**2], noise)[4000:]
    return band / np.std(band)


def weighed(seed: int, periods: Sequence[float]) -> tuple[float, float]:
    """Gain and evidence of a coupling to a channel of about 7 s, in water that moves with these periods."""
    water = sum((8.0 * narrow(seed, k, period) for k, period in enumerate(periods)), np.zeros(TIME.size))
    sway = narrow(seed, 9, 7.0)
    problem = turning(seed, command(seed, TIME), outside=10.0 * sway + water, channels={"sway": sway})
    effect = catalogue(["sway"])["coupling:sway"]
    found = settle(problem, [(effect, (0.0,), ())], nothing(problem))
    return gain_of(problem, found, 0), evidence(problem, found, 0)


@pytest.mark.parametrize("periods", [(), (4.0, 7.0, 13.0)])
def test_evidence_never_exceeds_the_gain(periods: tuple[float, ...]) -> None:
    for seed in range(2):
        gain, left = weighed(seed, periods)
        assert 0.0 < left <= gain


def test_noise_near_the_effects_own_frequency_that_the_ar_leaves_costs_evidence() -> None:
    for seed in range(2):
        (gain, left), (plain_gain, plain_left) = weighed(seed, (3.0, 8.0, 9.0)), weighed(seed, ())
        assert left / gain < 0.75 * plain_left / plain_gain
