"""Eq. 7 on whatever may come: ties, grids, duplicates, outliers, one sample, six dimensions, extreme parameters."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from incsvr.learning import dual
from incsvr.numerics import Array

MORE = np.longdouble  # more digits than the solver has, where the machine offers them


@st.composite
def sample_sets(draw: st.DrawFn) -> tuple[Array, Array]:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.sampled_from([1, 2, 3, 5, 20, 60, 110, 160]))
    dimensions = draw(st.sampled_from([1, 1, 1, 1, 6]))
    x = rng.uniform(-0.25, 0.25, (n, dimensions)) * draw(st.sampled_from([0.0, 1.0, 1.0, 1.0, 4.0]))
    speed = x[:, 0]
    y = 1300.0 * speed * np.abs(speed) + draw(st.sampled_from([0.0, 1e-3, 4.0])) * rng.normal(size=n)
    if draw(st.booleans()):
        x = np.round(x, 2)
    grid = draw(st.sampled_from([0.0, 0.0, 1.0, 5.0]))
    if grid:
        y = grid * np.round(y / grid)
    if draw(st.sampled_from([False, False, True])):
        y = np.full(n, draw(st.sampled_from([0.0, 5.0, -70.0])))
    outlier = draw(st.sampled_from([0.0, 0.0, 200.0, 1e6]))
    y = np.where(rng.random(n) < 0.1, y + outlier, y)
    return (x[:, 0] if dimensions == 1 else x), y


def gap_with_more_digits(x: Array, y: Array, theta: Array, gamma: float, C: float, epsilon: float) -> float:
    """P(f) + D(θ) from the definitions, less what rounding makes of it even so."""
    rows = x.reshape(y.size, -1).astype(MORE)
    K = np.exp(-MORE(gamma) * ((rows[:, None] - rows[None]) ** 2).sum(axis=-1))
    weight, target = theta.astype(MORE), y.astype(MORE)
    f = K @ weight
    norm = weight @ f / 2
    primal = norm + (C * np.maximum(np.abs(target - f) - epsilon, 0)).sum()
    dual_value = norm + (epsilon * np.abs(weight)).sum() - target @ weight
    return float(primal + dual_value - (y.size + 16) * np.finfo(MORE).eps * np.abs(primal))


@given(
    sample_sets(),
    st.sampled_from([0.1, 1.0, 5.0, 10.0, 30.0, 100.0, 1000.0]),
    st.sampled_from([1e-6, 1e-2, 1.0, 10.0, 1000.0, 1e4, 1e5]),
    st.sampled_from([0.0, 0.1, 1.0, 5.0]),
)
@settings(max_examples=300)
def test_it_is_solved_and_the_certificate_is_true(
    samples: tuple[Array, Array], gamma: float, C: float, epsilon: float
) -> None:
    x, y = samples
    solution = dual.solve(x, y, gamma=gamma, C=C, epsilon=epsilon)
    assert (np.abs(solution.weight) <= C).all()
    # With C = 10⁴ and more the digits of a float end before 0.01 N m are certain; the certificate says so.
    assert solution.certified_error <= (0.01 if C <= 1000.0 else 1e-5 * C)
    assert gap_with_more_digits(x, y, solution.weight, gamma, C, epsilon) <= solution.gap
