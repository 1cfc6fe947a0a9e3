"""The levels of a command that stays between its jumps: shared where it comes back to them, else each stay's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import catalogue
from incsvr.effects.effect import Term
from incsvr.tracing.run import Array
from incsvr.tracing.weak.levels import as_levels, shared
from tests.incsvr.turning import command, instants, turning

FIVE = np.array([-90.0, -45.0, 0.0, 45.0, 90.0])
STAY = 20
"""Samples."""


def lasting(seed: int, size: int) -> Array:
    """Noise of 3.5 N m that lasts some ten samples: the mean of a stay holds half of it."""
    white = np.random.default_rng(seed).normal(0.0, 3.5 * np.sqrt(1.0 - 0.9**2), size)
    noise: Array = lfilter([1.0], [1.0, -0.9], white)
    return noise


def stays(levels: Array) -> Array:
    """As `as_levels` leaves them: the command, and of its noise the mean over each stay."""
    command = np.repeat(levels, STAY)
    told: Array = command + np.repeat(lasting(3, command.size).reshape(-1, STAY).mean(axis=1), STAY)
    return told


def test_levels_that_a_command_comes_back_to_are_told_from_all_its_stays() -> None:
    levels = np.random.default_rng(1).choice(FIVE, 200)
    told = stays(levels)
    found = shared(told)
    assert found is not None
    assert np.unique(found).size == FIVE.size
    wrong, before = np.abs(found - np.repeat(levels, STAY)), np.abs(told - np.repeat(levels, STAY))
    assert np.max(wrong) < 1.5 < 4.0 < np.max(before)


def test_two_pairs_of_levels_are_four() -> None:
    """Of two levels each would hold two."""
    found = shared(stays(np.random.default_rng(2).choice([-96.0, -53.0, 53.0, 96.0], 83)))
    assert found is not None
    assert np.unique(found) == pytest.approx([-96.0, -53.0, 53.0, 96.0], abs=1.5)


@pytest.mark.parametrize("seed", range(5))
def test_a_command_that_takes_any_level_has_none_to_share(seed: int) -> None:
    assert shared(stays(np.random.default_rng(seed).uniform(-90.0, 90.0, 120))) is None


def test_a_level_that_is_hardly_visited_is_not_shared() -> None:
    assert shared(stays(np.random.default_rng(4).choice(FIVE, 9))) is None


def test_a_constant_command_has_no_levels_to_tell_apart() -> None:
    assert shared(np.full(400, 30.0)) is None


def test_cells_within_a_jump_stay_between_its_levels() -> None:
    levels = np.random.default_rng(5).choice(FIVE, 120)
    torque = np.repeat(levels, STAY)
    torque[STAY - 1 :: STAY][:-1] = 0.5 * (levels[:-1] + levels[1:])
    told = as_levels(turning(0, torque).signals)
    found = shared(told)
    assert found is not None
    within = ~np.isin(found, np.unique(found)[np.bincount(np.unique(found, return_inverse=True)[1]) > STAY])
    assert within.any()
    assert np.array_equal(found[within], told[within])


@pytest.mark.parametrize(
    ("term", "level", "thrust"),
    [
        (Term("torque_saturation", "limit", (1.0,), (60.0,)), 90.0, 60.0),
        (Term("dead_zone", "shifted", (1.0,), (10.0,)), 90.0, 80.0),
        (Term("torque_asymmetry", "", (0.5,)), -90.0, -60.0),
    ],
)
def test_a_cell_that_holds_a_jump_gives_the_mean_of_what_either_side_does(
    term: Term, level: float, thrust: float
) -> None:
    """A quarter of it is at the new level: that is not what the thrusters make of a command between the two."""
    effect = catalogue()[f"{term.effect}/{term.variant}" if term.variant else term.effect]
    signals = turning(0, command(0, instants(200.0))).signals
    torque = np.zeros(len(signals))
    torque[599], torque[600:] = 0.25 * level, level
    after = effect.thrust(torque, signals, term)
    assert after[600] == pytest.approx(thrust)
    assert after[599] == pytest.approx(0.25 * thrust)
