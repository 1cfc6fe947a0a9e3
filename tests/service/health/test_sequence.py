"""Lost messages are counted by their numbers, whatever the order in which they come."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.health.sequence import MAX_MISSING, Sequence


def lost(*numbers: int) -> int:
    sequence = Sequence()
    for number in numbers:
        sequence.add(number)
    return sequence.lost


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ((0, 1, 4, 5), 2),
        ((1, 0, 3, 2, 5, 4), 0),
        ((0, 3), 0),  # they may still come
        ((0, 3, 4), 2),
        ((0, 3, 4, 2, 1), 0),
        ((7, 7, 8, 8), 0),
        ((10, 11, 0, 1, 2), 0),  # the sender was restarted
        ((10_000, 0, 1, 3, 4), 1),
        ((0, 10**15, 10**15 + 1), 10**15 - 1),
    ],
)
def test_what_never_came_is_lost(numbers: tuple[int, ...], expected: int) -> None:
    assert lost(*numbers) == expected


@given(st.permutations(range(40)), st.sets(st.integers(1, 39)))
def test_any_order_counts_the_same(order: list[int], dropped: set[int]) -> None:
    begin, end = [-1], [100, 101]
    came = [number for number in order if number not in dropped]
    gone = 99 - 39 - 1 + 1
    assert lost(*begin, *came, *end) == len(dropped) + gone


def test_memory_is_bounded() -> None:
    sequence = Sequence()
    for number in range(0, 10 * MAX_MISSING, 2):
        sequence.add(number)
    assert sequence.lost == 5 * MAX_MISSING - 2
    assert len(sequence._missing) <= MAX_MISSING
