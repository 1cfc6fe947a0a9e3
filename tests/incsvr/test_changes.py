"""The test of change over dives: its level, since when, and what explains a change."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.vehicle.causes import fitting_causes
from incsvr.vehicle.changes import LEVEL, Changes, changes
from incsvr.vehicle.compare import Quantity
from incsvr.vehicle.history import History

FREEDOM = 12.0


def dives(truth: Array, seed: int) -> tuple[Array, Array]:
    """Estimates of 2 % about a truth (quantities, dives), and standard errors that are estimates, too."""
    rng = np.random.default_rng(seed)
    error = 0.02 * truth
    shown = error * np.sqrt(rng.chisquare(FREEDOM, truth.shape) / FREEDOM)
    return truth + error * rng.standard_normal(truth.shape), shown


def compared(estimate: Array, error: Array, quantities: int) -> Changes:
    return changes(estimate, error, np.full(estimate.shape, FREEDOM), np.full(estimate.shape[0], 1.0 / quantities))


def test_unchanged_vehicles_are_left_alone_at_the_level() -> None:
    vehicles, quantities = 1500, 4
    found = compared(*dives(np.ones((vehicles * quantities, 30)), 601), quantities)
    false = found.changed.reshape(vehicles, -1).any(axis=1).mean()
    assert 0.3 * LEVEL < false < LEVEL + 3.0 * np.sqrt(LEVEL / vehicles)


def test_a_step_is_found_in_its_dive_and_is_the_norm_from_there() -> None:
    truth = np.ones((50, 20))
    truth[:, 8:] = 1.3
    found = compared(*dives(truth, 602), 4)
    assert np.mean(found.changed[:, 8]) > 0.9
    assert found.reference[:, 12:] == pytest.approx(1.3, rel=0.05)


def test_a_dive_without_the_quantity_is_passed_over() -> None:
    estimate, error = dives(np.ones((1, 10)), 603)
    estimate[0, 4] = np.nan
    found, without = compared(estimate, error, 1), compared(np.delete(estimate, 4, 1), np.delete(error, 4, 1), 1)
    assert np.delete(found.p_value, 4, 1)[0, 1:] == pytest.approx(without.p_value[0, 1:])
    assert np.isnan(found.p_value[0, 4])


def history(speed: Array, estimate: Array, error: Array) -> History:
    """Two vehicles, whose dives come in turns, with a yaw drag each."""
    count = estimate.size
    vehicle, zero = np.arange(count) % 2, np.zeros(count, dtype=np.int64)
    names = (["one", "other"], ["yaw"], ["drag"])
    return History(vehicle, zero, zero, names, speed, estimate, error, np.full(count, FREEDOM))


def test_each_vehicle_of_a_table_is_compared_with_its_own_past() -> None:
    estimate, error = dives(np.array([[1.0] * 6, [9.0] * 3 + [12.0] * 3]), 604)
    found = history(np.ones(12), estimate.T.ravel(), error.T.ravel()).changes()
    assert np.flatnonzero(found.changed).tolist() == [7]
    alone = compared(estimate, error, 1)
    assert found.p_value[1::2] == pytest.approx(alone.p_value[1], nan_ok=True)


def test_drags_at_several_speeds_are_refused() -> None:
    estimate, error = dives(np.ones((1, 6)), 605)
    speed = np.array([0.3, 1.0, 0.3, 1.0, 0.5, 1.0])
    with pytest.raises(BadInput, match=r"one: its yaw drag is given at several speeds, 0\.3 to 0\.5"):
        history(speed, estimate[0], error[0]).changes()


QUANTITIES = tuple(Quantity(axis, kind) for kind in ("inertia", "drag") for axis in ("surge", "sway", "yaw"))


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ((1.0, 1.0, 1.0, 1.2, 1.2, 1.2), "all drags changed alike (+20 %), as by fouling or by its removal"),
        ((1.0, 1.0, 1.25, 1.0, 1.0, 1.25), "inertia and drag of yaw grew alike, as if 20 % of its effort were lost"),
        ((1.0, 1.0, 1.0, 1.0, 0.8, 1.0), "the sway drag alone changed (-20 %)"),
        ((1.2, 1.2, 1.2, 1.2, 1.2, 1.2), "all inertias and drags changed alike (+20 %)"),
    ],
)
def test_the_one_cause_that_fits_is_named(factors: tuple[float, ...], words: str) -> None:
    before = np.array([30.0, 60.0, 8.0, 4.0, 25.0, 9.0])
    now = before * np.array(factors)
    found = fitting_causes(QUANTITIES, now, 0.01 * now, before, 0.005 * before)
    assert found[0].what.startswith(words)
    assert len(found) == 1


def test_changes_that_no_single_cause_makes_have_none() -> None:
    before = np.ones(6)
    now = np.array([1.3, 1.0, 1.1, 1.2, 1.0, 1.6])
    assert fitting_causes(QUANTITIES, now, 0.01 * now, before, 0.005 * before) == ()
