"""The baselines that come from libraries: right where the truth is known, behind the interface of the others."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.paper.baselines import Baseline, Data
from benchmarks.paper.library_baselines import LeastSquaresSVR, NeuralNetwork
from incsvr.learning.kernel import rbf
from tests.benchmarks.test_baselines import data, worst


@pytest.mark.parametrize("baseline", [LeastSquaresSVR(), NeuralNetwork(decay=1e-4)])
def test_the_curve_is_found(baseline: Baseline) -> None:
    assert worst(baseline, data(80.0)) < 1.0
    assert 0.01 < worst(baseline, data(400.0, noise=4.0)) < 4.0


def test_the_least_squares_svr_solves_its_system() -> None:
    """(K + I/C) θ = y, at some point of the grid."""
    given = data(80.0, noise=4.0).samples
    curve = LeastSquaresSVR().fit(Data(given, *(np.empty(0),) * 3))
    kernel = rbf(given.yaw_rate, given.yaw_rate, curve.gamma)
    rest = given.damping - kernel @ curve.weight
    C = float(np.median(curve.weight / rest))
    assert any(pytest.approx(each, rel=1e-3) == C for each in (10.0, 100.0, 1e3, 1e4))
    np.testing.assert_allclose(rest, curve.weight / C, atol=1e-6)


def test_a_network_gives_the_same_curve_again() -> None:
    given, rates = data(80.0, noise=4.0), np.linspace(-0.2, 0.2, 9)
    first, second = (NeuralNetwork().fit(given).predict(rates) for _ in range(2))
    np.testing.assert_array_equal(first, second)
