"""Eq. 8, the reference: it walks to the solution of Eq. 7, slowly."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.learner_times import yaw_samples
from incsvr.learning import dual
from incsvr.learning.kernel import rbf


@pytest.mark.parametrize("seed", range(3))
def test_it_reaches_what_solve_reaches(seed: int) -> None:
    x, y = yaw_samples(seed, old=20, new=20)
    exact = dual.solve(x, y, gamma=30.0, C=100.0, epsilon=1.0)
    walked = dual.coordinate_descent(x, y, gamma=30.0, C=100.0, epsilon=1.0, passes=20_000, gap=1e-9)
    assert walked.gap <= 1e-9 * abs(walked.objective)
    apart = np.abs(rbf(x, x, 30.0) @ (walked.weight - exact.weight)).max()
    assert apart <= walked.certified_error + exact.certified_error
    assert exact.objective <= walked.objective


def test_the_signs_as_printed_in_the_paper_would_ascend() -> None:
    """One sample tells them apart: y = 5 must give θ = 5 − ε."""
    y, epsilon, C = 5.0, 0.1, 1000.0
    walked = dual.coordinate_descent([0.1], [y], gamma=10.0, C=C, epsilon=epsilon)
    assert walked.weight == pytest.approx([y - epsilon])
    alpha = float(np.clip(0.0 - (epsilon + y - 0.0), 0.0, C))
    beta = float(np.clip(0.0 - (epsilon - y + alpha), 0.0, C))
    printed = alpha - beta
    assert 0.5 * printed**2 + epsilon * abs(printed) - y * printed > 0.0  # worse than not starting at all
