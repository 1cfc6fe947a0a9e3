"""L Lᵀ is the kernel matrix, whichever way L is made."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.learning.solver import factor as factors
from incsvr.learning.solver.factor import factor


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


def test_samples_that_have_too_little_in_common_are_refused_before_memory_is_n_squared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    x = np.linspace(0.0, 1e6, 1500)
    monkeypatch.setattr(factors, "MAX_COLUMNS", 50)
    with pytest.raises(BadInput, match="lower gamma or take at most 50 samples"):
        factor(x, 10.0)
    assert factor(x[:300] * 1e-5, 10.0).shape[0] <= 50  # as many samples may be, if they have enough in common
