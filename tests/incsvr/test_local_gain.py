"""Whether the thrust answers its command with one gain throughout."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.tracing.local_gain import sentence, uneven_gain

PER_SCALE = 12.0


def command(random: np.random.Generator, count: int) -> Array:
    """Levels that hold for a while."""
    ends = np.cumsum(random.integers(10, 60, count))
    return np.asarray(random.uniform(-1.0, 1.0, count)[np.searchsorted(ends, np.arange(count), side="right")])


@pytest.mark.parametrize("seed", range(3))
def test_spells_of_half_the_thrust_are_found(seed: int) -> None:
    random = np.random.default_rng([seed, 3])
    torque = command(random, 4000)
    lost = np.zeros(4000)
    for begin in (400, 1300, 2500, 3300):
        lost[begin : begin + 100] = 0.5 * torque[begin : begin + 100]
    inside = uneven_gain(lost + random.normal(0.0, 0.15, 4000), torque, PER_SCALE)
    assert inside[lost != 0.0].mean() > 0.5
    assert inside[lost == 0.0].mean() < 0.1


@pytest.mark.parametrize("seed", range(3))
def test_noise_beside_a_command_has_one_gain(seed: int) -> None:
    random = np.random.default_rng([seed, 4])
    assert not uneven_gain(random.standard_t(6.0, 4000), command(random, 4000), PER_SCALE).any()


def test_a_gain_that_differs_by_less_than_a_thrust_table_is_known_says_nothing() -> None:
    random = np.random.default_rng(5)
    torque = command(random, 4000)
    lost = np.where(np.arange(4000) < 2000, 0.03, -0.03) * torque
    assert not uneven_gain(lost + random.normal(0.0, 0.01, 4000), torque, PER_SCALE).any()


def test_without_torque_there_is_nothing_to_be_told() -> None:
    assert not uneven_gain(np.random.default_rng(6).standard_normal(4000), np.zeros(4000), PER_SCALE).any()


def test_the_sentence_names_the_first_spells_and_counts_the_rest() -> None:
    words = sentence([(10.0 * k, 10.0 * k + 5.0) for k in range(7)])
    assert "0–5 s" in words
    assert "2 more" in words
