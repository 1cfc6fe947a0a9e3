"""The paper's policy against Fig. 3 written out a second time, sample by sample."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from incsvr.learning.dual import solve
from incsvr.learning.kernel import rbf
from incsvr.learning.learner import Settings, State, start, step
from incsvr.learning.paper import Memory, forgetting
from incsvr.signals.samples import Samples
from tests.incsvr.learning import batches, drag, rms, run, stream

PAPER = Settings(policy="paper")
Points = list[tuple[float, float]]


def kernel(a: float, b: float) -> float:
    return float(np.exp(-PAPER.gamma * (a - b) ** 2))


def theta(points: Points) -> list[float]:
    x, y = np.array([p[0] for p in points]), np.array([p[1] for p in points])
    return [float(weight) for weight in solve(x, y, gamma=PAPER.gamma, C=PAPER.C, epsilon=PAPER.epsilon).weight]


def value(points: Points, weights: list[float], rate: float) -> float:
    return sum(weight * kernel(point[0], rate) for point, weight in zip(points, weights, strict=True))


def forget_one_by_one(rate: list[float], capacity: int, bins: int, low: float, high: float) -> list[int]:
    """As the paper says it: while there are more than `capacity`, delete the oldest in the fullest bin."""
    left = list(range(len(rate)))
    place = [min(max(int((r - low) / (high - low) * bins), 0), bins - 1) for r in rate]
    while len(left) > capacity:
        members: dict[int, list[int]] = {}
        for position in left:
            members.setdefault(place[position], []).append(position)
        fullest = max(len(group) for group in members.values())
        left.remove(min(group[0] for group in members.values() if len(group) == fullest))
    return left


@given(
    # On a grid of sixty-fourths, so that no rounding decides on which side of a bin's edge a rate lies.
    rate=st.lists(st.integers(-80, 80).map(lambda k: k / 64), min_size=0, max_size=60),
    capacity=st.integers(1, 50),
    bins=st.sampled_from([1, 2, 8, 32]),
)
def test_forgetting_is_the_papers_one_by_one(rate: list[float], capacity: int, bins: int) -> None:
    stays = forgetting(Settings(capacity=capacity, bins=bins, rate_range=(-1.0, 1.0)), np.array(rate))
    assert np.flatnonzero(stays).tolist() == forget_one_by_one(rate, capacity, bins, -1.0, 1.0)


def reference_step(vectors: Points, served: tuple[Points, list[float]], batch: Points) -> tuple[Points, Points]:
    """(vectors carried over, vectors served), as III-C and Fig. 3 say it; the solver is the only thing shared."""
    new = []
    for x, y in batch:
        if served[0] and abs(value(*served, x) - y) < 0.1:
            continue
        if any(abs(x - vx) < 0.01 and abs(y - vy) < 5.0 for vx, vy in vectors):
            continue
        new.append((x, y))
    if not new:
        return vectors, served[0]
    kept = forget_one_by_one([x for x, _ in vectors], 60, PAPER.bins, -0.25, 0.25)
    stack = [vectors[i] for i in kept] + new
    weights = theta(stack)
    support = [(p, w) for p, w in zip(stack, weights, strict=True) if w != 0.0]
    residuals = [value([p for p, _ in support], [w for _, w in support], p[0]) - p[1] for p, _ in support]
    first, third = np.percentile(residuals, (25, 75))
    reach = 1.5 * (third - first)
    carried = [p for (p, _), r in zip(support, residuals, strict=True) if first - reach <= r <= third + reach]
    left = forget_one_by_one([x for x, _ in carried], 60, PAPER.bins, -0.25, 0.25)
    return carried, [carried[i] for i in left]


def points(samples: Samples) -> Points:
    return list(zip(samples.yaw_rate.tolist(), samples.damping.tolist(), strict=True))


def test_an_iteration_is_the_papers() -> None:
    state = start(PAPER)
    vectors: Points = []
    served: tuple[Points, list[float]] = ([], [])
    for batch in batches(stream(1, 500, hull_from=300, wild=0.05)):
        state, iteration = step(PAPER, state, batch)
        undriven = points(iteration.undriven)  # a few as the rate passes zero: they reach no policy
        vectors, last = reference_step(vectors, served, [point for point in points(batch) if point not in undriven])
        served = (last, theta(last))
        assert isinstance(state.memory, Memory)
        assert points(state.memory.vectors) == vectors
        assert points(iteration.support) == last
        for rate in (-0.24, -0.1, 0.0, 0.05, 0.24):
            at = float(iteration.model.evaluate(np.array([rate]))[0])
            assert at == pytest.approx(value(*served, rate), abs=0.02)


def test_what_is_served_is_solved_on_what_is_kept_and_never_a_pruned_sum() -> None:
    rates = np.linspace(-0.24, 0.24, 49)
    pruned_errors, served_errors = [], []
    for iteration_state in states(stream(2, 700, wild=0.05)):
        memory, model = iteration_state.memory, iteration_state.model
        assert isinstance(memory, Memory)
        again = solve(model.support_rate, model.support_damping, gamma=PAPER.gamma, C=PAPER.C, epsilon=PAPER.epsilon)
        solved = rbf(rates, model.support_rate, PAPER.gamma) @ again.weight
        assert np.abs(model.evaluate(rates) - solved).max() <= model.certified_error + again.certified_error < 0.01
        if not memory.stays.all():
            rate, weight = memory.vectors.yaw_rate[memory.stays], memory.weight[memory.stays]
            pruned = np.exp(-PAPER.gamma * np.subtract.outer(rates, rate) ** 2) @ weight
            pruned_errors.append(rms(pruned - drag(rates)))
            served_errors.append(rms(model.evaluate(rates) - drag(rates)))
    # What the rule guards against is there: the sums that are carried over as a warm start are no damping curves.
    assert len(pruned_errors) >= 5
    assert min(pruned_errors) > 50.0
    assert max(served_errors) < 8.0


def states(samples: Samples) -> list[State]:
    state, found = start(PAPER), []
    for batch in batches(samples):
        state, _ = step(PAPER, state, batch)
        found.append(state)
    return found


def test_a_batch_that_tells_nothing_new_trains_nothing() -> None:
    state, iterations = run(PAPER, stream(3, 400))
    assert isinstance(state.memory, Memory)
    known = state.memory.vectors.take(slice(0, 50))
    after, iteration = step(PAPER, state, known)
    assert not iteration.trained
    assert len(iteration.discarded_near) + len(iteration.discarded_tube) == 50
    assert after.model is state.model
    assert after.memory is state.memory
    assert after.iterations == len(iterations) + 1
    assert len(iteration.forgotten) == len(iteration.outliers) == len(iteration.new) == 0


@pytest.mark.slow
def test_eq_8_passes_from_the_warm_start_come_near_the_exact_model() -> None:
    samples = stream(4, 200)
    rates = np.linspace(-0.2, 0.2, 41)
    _, exact = run(PAPER, samples)
    _, passes = run(Settings(policy="paper", solver="passes"), samples)
    curves = [iterations[-1].model.evaluate(rates) for iterations in (exact, passes)]
    assert rms(curves[0] - curves[1]) < 3.0
    assert rms(curves[1] - drag(rates)) < 6.0
