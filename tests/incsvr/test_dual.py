"""Eq. 7 solved exactly: what it promises on ordinary, degenerate and bad input."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.learner_times import yaw_samples
from incsvr.errors import BadInput
from incsvr.learning import dual, kernel
from incsvr.learning.kernel import rbf
from incsvr.numerics import Array

PAPER: dict[str, Any] = {"gamma": 10.0, "C": 1000.0, "epsilon": 0.1}


def violation(x: Array, y: Array, theta: Array, gamma: float, C: Array, epsilon: Array) -> float:
    """The largest violation of the optimality conditions of Eq. 7 [N m], straight from their statement."""
    residual = y - rbf(x, x, gamma) @ theta
    worst = 0.0
    for r, t, c, e in zip(residual, theta, C, epsilon, strict=True):
        if t == 0.0:
            worst = max(worst, abs(r) - e)
        elif abs(t) == c:
            worst = max(worst, e - np.sign(t) * r)
        else:
            worst = max(worst, abs(np.sign(t) * r - e))
    return float(worst)


def test_no_samples_give_the_zero_model() -> None:
    solution = dual.solve([], [], **PAPER)
    assert solution.weight.shape == (0,)
    assert solution.certified_error == 0.0


def test_each_sample_can_have_its_own_bound_and_tube() -> None:
    x, y = yaw_samples(3)
    rng = np.random.default_rng(3)
    C, epsilon = 10.0 ** rng.uniform(-1.0, 3.5, y.size), rng.uniform(0.0, 6.0, y.size)
    solution = dual.solve(x, y, gamma=10.0, C=C, epsilon=epsilon)
    assert (np.abs(solution.weight) <= C).all()
    assert violation(x, y, solution.weight, 10.0, C, epsilon) < 1e-8
    assert solution.certified_error < 0.01


@pytest.mark.parametrize("seed", [1080, 1445, 2702])
def test_it_does_not_go_round_in_circles(seed: int) -> None:
    """Where Mehrotra's method as published does: its 60th iteration is as far away as its tenth."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, 20)
    y = 1300.0 * x * np.abs(x) + 4.0 * rng.normal(size=20)
    solution = dual.solve(x, y, gamma=30.0, C=1e5, epsilon=0.0)
    assert solution.iterations < 15
    assert solution.certified_error < 0.1


@pytest.mark.slow
def test_offline_sets_need_memory_in_proportion_to_their_size() -> None:
    x, y = yaw_samples(8, old=10000, new=10000)
    tracemalloc.start()
    solution = dual.solve(x, y, **PAPER)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert solution.certified_error < 0.01
    assert peak < 200 * 8 * y.size  # 200 numbers for each sample; the kernel matrix would be 20,000


def test_samples_with_too_little_in_common_are_refused_before_memory_grows() -> None:
    x = np.linspace(0.0, 1e6, kernel.MAX_SAMPLES + 1)
    with pytest.raises(BadInput, match=f"lower gamma or take at most {kernel.MAX_SAMPLES} samples"):
        dual.solve(x, np.sin(x), **PAPER)
    assert dual.solve(x[:300] * 1e-5, np.sin(x[:300]), **PAPER).certified_error < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_the_papers_passes_reach_what_solve_reaches(seed: int) -> None:
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


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"y": [1.0, 2.0]}, "x has shape"),
        ({"x": [[[0.1]], [[0.2]], [[0.3]]]}, "x has shape"),
        ({"x": [0.1, np.nan, 0.2]}, "x holds NaN"),
        ({"y": [1.0, np.inf, 2.0]}, "y holds NaN, infinity"),
        ({"y": [1.0, np.inf, -np.inf]}, "y holds NaN, infinity"),
        ({"y": [1.0, 1e40, 2.0]}, "beyond 1e\\+30"),
        ({"C": 0.0}, "C must be positive"),
        ({"C": [1.0, 2.0]}, "C has shape"),
        ({"C": [1.0, -2.0, 3.0]}, "C must be positive"),
        ({"C": np.inf}, "C holds NaN, infinity"),
        ({"epsilon": -0.1}, "epsilon zero or more"),
        ({"epsilon": [0.1]}, "epsilon has shape"),
        ({"gamma": 0.0}, "gamma is 0.0"),
        ({"gamma": np.nan}, "gamma is nan"),
        ({"gamma": np.inf}, "gamma is inf"),
    ],
)
@pytest.mark.parametrize("solver", [dual.solve, dual.coordinate_descent])
def test_bad_input_is_one_clear_sentence(solver: Any, changes: dict[str, Any], sentence: str) -> None:
    given = {"x": [0.0, 0.1, 0.2], "y": [0.0, 1.0, 2.0], **PAPER, **changes}
    with pytest.raises(BadInput, match=sentence):
        solver(**given)


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
