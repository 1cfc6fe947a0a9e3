"""Weighted vectors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from incsvr.learning.policies.merging import Vectors
from incsvr.signals.samples import Samples

EACH = 1.0 / 16.0
FASTEST = np.array([0.3])


def samples(rate: list[float], damping: list[float]) -> Samples:
    return Samples(np.linspace(1, len(rate), len(rate)), np.array(rate), np.array(damping))


def test_a_sample_joins_the_vector_beside_it_by_the_running_mean() -> None:
    vectors = Vectors.of(samples([0.1, 0.2], [10.0, 20.0]), information=3 * EACH)
    joined = vectors.absorb(samples([0.104, 0.15], [14.0, 15.0]), FASTEST, 0.006, each=EACH, most=15 * EACH)
    np.testing.assert_allclose(joined.points.yaw_rate, [0.101, 0.15, 0.2])
    np.testing.assert_allclose(joined.points.damping, [11.0, 15.0, 20.0])
    np.testing.assert_allclose(joined.information / EACH, [4.0, 1.0, 3.0])
    assert joined.points.time.tolist() == [1.0, 2.0, 2.0]


def test_the_two_closest_neighbours_become_their_weighted_mean() -> None:
    four = samples([0.0, 0.1, 0.13, 0.3], [0.0, 10.0, 16.0, 30.0])
    vectors = replace(Vectors.of(four, information=1.0), information=np.array([1.0, 1.0, 2.0, 1.0]))
    merged = vectors.condense(FASTEST, 3, most=15.0)
    np.testing.assert_allclose(merged.points.yaw_rate, [0.0, 0.12, 0.3])
    np.testing.assert_allclose(merged.points.damping, [0.0, 14.0, 30.0])
    np.testing.assert_allclose(merged.information, [1.0, 3.0, 1.0])


rates = st.lists(st.floats(-0.3, 0.3), min_size=1, max_size=80)


@given(first=rates, second=rates, capacity=st.integers(1, 30))
def test_nothing_is_lost_but_what_the_cap_takes(first: list[float], second: list[float], capacity: int) -> None:
    count = len(first) + len(second)
    made = Vectors.empty()
    for part in (first, second):
        heights = [100.0 * rate + 1.0 for rate in part]
        made = made.absorb(samples(part, heights), FASTEST, 0.006, each=1.0, most=1e9)
    made = made.condense(FASTEST, capacity, most=1e9)
    assert len(made) <= capacity
    assert (np.diff(made.points.yaw_rate) >= 0.0).all()
    np.testing.assert_allclose(made.information.sum(), count)
    # Means of points of one straight line lie on it, and their centre of mass stays.
    np.testing.assert_allclose(made.points.damping, 100.0 * made.points.yaw_rate + 1.0, atol=1e-9)
    np.testing.assert_allclose(made.information @ made.points.yaw_rate, sum(first) + sum(second), atol=1e-9)


def test_information_is_capped_also_where_nothing_joins() -> None:
    vectors = Vectors.of(samples([0.1, 0.2], [10.0, 20.0]), information=100.0)
    assert vectors.absorb(samples([0.0], [0.0]), FASTEST, 0.006, each=1.0, most=15.0).information.max() == 15.0
