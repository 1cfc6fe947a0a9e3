"""Weighted vectors."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from incsvr.learning.policies.merging import Vectors
from incsvr.signals.samples import Samples

FASTEST = np.array([0.3])


def samples(rate: list[float], damping: list[float]) -> Samples:
    return Samples(np.linspace(1, len(rate), len(rate)), np.array(rate), np.array(damping))


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
