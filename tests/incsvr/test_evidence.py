"""p-values, intervals and the bootstrap of a change, against what they promise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.evidence import change_of_rms, p_value, rms
from incsvr.tracer.proof import sample_errors
from incsvr.tracer.run import Array


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
