"""L Lᵀ is the kernel matrix, whichever way L is made."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.learning.kernel import rbf
from incsvr.learning.solver import factor as factors
from incsvr.learning.solver.factor import factor
from incsvr.numerics import Array

RNG = np.random.default_rng(1)
NARROW = RNG.uniform(-0.25, 0.25, 300)


@pytest.mark.parametrize("gamma", [0.1, 5.0, 10.0, 30.0, 60.0, 100.0, 1000.0])
@pytest.mark.parametrize("n", [1, 2, 100, 300])
def test_on_yaw_rates(gamma: float, n: int) -> None:
    x = NARROW[:n]
    LT = factor(x, gamma)
    assert LT.flags.c_contiguous
    assert np.abs(LT.T @ LT - rbf(x, x, gamma)).max() < 1e-14


@pytest.mark.parametrize(
    "x",
    [np.full(40, 0.1), np.round(NARROW, 2), NARROW + 1e3, NARROW * 400.0, RNG.normal(size=(90, 6))],
    ids=["equal", "grid", "far from zero", "wide", "6-D"],
)
def test_on_unusual_samples(x: Array) -> None:
    LT = factor(x, 10.0)
    assert np.abs(LT.T @ LT - rbf(x, x, 10.0)).max() < 2e-14


def test_the_rank_is_small_on_the_range_of_a_vehicle() -> None:
    assert factor(NARROW, 10.0).shape[0] == 20


@pytest.mark.parametrize("gamma", [10.0, 1000.0])
def test_memory_is_never_n_squared(gamma: float) -> None:
    n = 6000
    x = np.random.default_rng(2).uniform(-0.25, 0.25, n)
    tracemalloc.start()
    LT = factor(x, gamma)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5 * LT.nbytes + 100 * n
    assert peak < n * n * 8 / 10


def test_pivots_with_and_without_the_whole_matrix_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    x = RNG.normal(size=(120, 2))
    whole = factor(x, 1.0)
    monkeypatch.setattr(factors, "MAX_WHOLE_SAMPLES", 10)
    by_rows = factor(x, 1.0)
    assert np.abs(whole.T @ whole - by_rows.T @ by_rows).max() < 2e-14


def test_samples_that_have_too_little_in_common_are_refused_before_memory_is_n_squared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    x = np.linspace(0.0, 1e6, 1500)
    monkeypatch.setattr(factors, "MAX_COLUMNS", 50)
    with pytest.raises(BadInput, match="lower gamma or take at most 50 samples"):
        factor(x, 10.0)
    assert factor(x[:300] * 1e-5, 10.0).shape[0] <= 50  # as many samples may be, if they have enough in common
