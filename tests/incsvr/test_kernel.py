"""κ(x, z) = exp(−γ‖x − z‖²)."""

from __future__ import annotations

import math

import numpy as np

from incsvr.learning.kernel import rbf


def test_the_kernel_is_the_formula_of_the_paper() -> None:
    K = rbf(np.array([0.0, 0.2]), np.array([0.2, -0.1, 0.0]), 10.0)
    assert K.shape == (2, 3)
    assert K[0, 0] == math.exp(-10.0 * 0.2**2)
    assert K[1, 0] == 1.0
    np.testing.assert_allclose(K[1], [1.0, math.exp(-0.9), math.exp(-0.4)], rtol=1e-15)


def test_in_six_dimensions_it_is_the_product_over_the_coordinates() -> None:
    rng = np.random.default_rng(0)
    x, z = rng.normal(size=(5, 6)), rng.normal(size=(4, 6))
    each = [rbf(x[:, k], z[:, k], 0.7) for k in range(6)]
    np.testing.assert_allclose(rbf(x, z, 0.7), np.prod(each, axis=0), rtol=1e-13)


def test_points_that_lie_close_together_do_not_cancel() -> None:
    x = np.array([[1000.0, 0.0], [1000.0 + 1e-6, 0.0]])
    distance = x[1, 0] - x[0, 0]
    assert rbf(x, x, 1e10)[0, 1] == math.exp(-1e10 * distance**2)
