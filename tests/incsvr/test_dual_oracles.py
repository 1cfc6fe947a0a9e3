"""Eq. 7 against solvers that share nothing with ours: clarabel on the primal, libsvm with its bias pinned at zero."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.svm import SVR

from benchmarks.learner_times import by_clarabel, yaw_samples
from incsvr.learning import dual
from incsvr.learning.kernel import rbf


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_clarabel(seed: int) -> None:
    """On the paper's whole grid of parameters (Section IV-B), outliers included."""
    rng = np.random.default_rng(seed)
    gamma = float(rng.choice([5.0, 10.0, 20.0, 30.0]))
    C = float(rng.choice([10.0, 100.0, 1000.0]))
    epsilon = float(rng.choice([0.1, 1.0, 2.0, 5.0]))
    x, y = yaw_samples(seed)
    y = np.where(rng.random(y.size) < 0.05 * (seed % 3), y + 500.0, y)
    ours = dual.solve(x, y, gamma=gamma, C=C, epsilon=epsilon)
    theirs = by_clarabel(x, y, gamma, C, epsilon)
    assert np.abs(rbf(x, x, gamma) @ ours.weight - theirs).max() < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_libsvm_whose_bias_two_heavy_rows_pin_at_zero(seed: int) -> None:
    x, y = yaw_samples(seed)
    n = y.size
    K = np.zeros((n + 2, n + 2))
    K[:n, :n] = rbf(x, x, 10.0)
    machine = SVR(kernel="precomputed", C=1000.0, epsilon=0.1, tol=1e-9)
    machine.fit(K, np.r_[y, 0.1, -0.1], sample_weight=np.r_[np.ones(n), 1e6, 1e6])
    assert abs(machine.intercept_[0]) < 1e-6
    ours = dual.solve(x, y, gamma=10.0, C=1000.0, epsilon=0.1)
    # libsvm keeps the kernel in single precision: with weights of 1000 N m it cannot come nearer than this.
    assert np.abs(rbf(x, x, 10.0) @ ours.weight - machine.predict(K)[:n]).max() < 5e-3
