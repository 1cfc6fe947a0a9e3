"""The criteria of Section III-C against what the paper says, computed by hand or one by one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from incsvr.learning.criteria import forgetting, inclusion, outliers, quartiles


def test_inclusion_discards_what_lies_in_the_tube_or_beside_a_vector() -> None:
    rate = np.array([0.10, 0.10, 0.105, 0.111, 0.10, -0.10])
    damping = np.array([20.05, 20.1, 24.9, 24.9, 25.0, 20.0])
    verdict = inclusion(
        rate,
        damping,
        np.full(6, 20.0),
        np.array([0.10]),
        np.array([20.0]),
        epsilon=0.1,
        near_rate=0.01,
        near_damping=5.0,
    )
    # |f − y| = 0.05 < ε; ≥ ε but beside; beside; |Δx| ≥ a; |Δy| ≥ b; in the tube.
    assert verdict.in_tube.tolist() == [True, False, False, False, False, True]
    assert verdict.near.tolist() == [False, True, True, False, False, False]
    assert verdict.kept.tolist() == [False, False, False, True, True, False]


def test_before_anything_is_learned_no_tube_holds_a_sample() -> None:
    three, nothing = np.zeros(3), np.empty(0)
    verdict = inclusion(three, three, None, nothing, nothing, epsilon=0.1, near_rate=0.01, near_damping=5.0)
    assert verdict.kept.all()


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
    stays = forgetting(np.array(rate), capacity=capacity, bins=bins, rate_range=(-1.0, 1.0))
    assert np.flatnonzero(stays).tolist() == forget_one_by_one(rate, capacity, bins, -1.0, 1.0)


def test_forgetting_takes_the_oldest_of_the_fullest_bin() -> None:
    rate = np.array([-0.2, 0.1, 0.11, 0.12, -0.21, 0.13])
    stays = forgetting(rate, capacity=4, bins=2, rate_range=(-0.25, 0.25))
    assert stays.tolist() == [True, False, False, True, True, True]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=120))
def test_quartiles_are_numpys(values: list[float]) -> None:
    np.testing.assert_allclose(quartiles(np.array(values)), np.percentile(values, (25, 50, 75)), rtol=1e-12, atol=1e-9)


def test_outliers_lie_beyond_one_and_a_half_interquartile_ranges() -> None:
    # Quartiles of 1…9 are 3 and 7: the fences stand at −3 and 13.
    residual = np.array([1.0, 2, 3, 4, 5, 6, 7, 8, 9])
    assert not outliers(residual).any()
    assert outliers(np.append(residual[:-1], 13.5)).tolist() == [False] * 8 + [True]
    assert outliers(np.append(residual[1:], -20.0)).tolist() == [False] * 8 + [True]
    assert outliers(np.empty(0)).size == 0
