"""The fit of a vehicle that turns: what is known of it, how far, and what bends it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.model.fitting import Fit, Problem, costs_of, fit
from incsvr.model.identification import plain_fit, structure_of
from incsvr.model.intervals import halved, intervals
from incsvr.model.left_out import folds, gain, left_out
from incsvr.model.rows import damping
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams
from tests.incsvr.model.turning import Turning, dive

QUICK = Turning(inertia=6.0)
"""It settles in some 0.7 s, three time constants."""
INERTIA, LINEAR, QUADRATIC, SHIFT = "mass:yaw_rate", "linear@yaw_rate", "quadratic@yaw_rate", "shift:yaw_rate"


def plain(log: Streams) -> Fit:
    return plain_fit(structure_of([log], ["yaw_rate"]), [log])


@pytest.mark.parametrize("way", ["hold", "linear"])
@pytest.mark.parametrize("seed", [1, 2])
def test_inertia_drag_and_a_clocks_offset_are_found(way: str, seed: int) -> None:
    found = plain(dive(QUICK, seed, early=0.037, way=way))
    known = intervals(found, [halved(found)])
    assert found.structure.ways == {"yaw_rate": way}
    assert known[INERTIA].value == pytest.approx(QUICK.inertia, rel=0.02)
    assert known[INERTIA].low < QUICK.inertia < known[INERTIA].high
    assert known[SHIFT].value == pytest.approx(0.037, abs=0.005)
    assert known[LINEAR].low < QUICK.linear < known[LINEAR].high
    assert known[QUADRATIC].low < QUICK.quadratic < known[QUADRATIC].high


@pytest.mark.parametrize("seed", [2, 3])
def test_halving_widens_the_interval_of_a_log_that_is_too_coarse(seed: int) -> None:
    """At 4 Hz, a third of the settling time, a torque that changes every 0.1 s is not in the log."""
    found = plain(dive(QUICK, seed, rate=4.0, way="linear"))
    blocks, both = intervals(found)[INERTIA], intervals(found, [halved(found)])[INERTIA]
    assert both.high - both.low > 3.0 * (blocks.high - blocks.low)
    assert both.moved > 1.0
    assert both.low < QUICK.inertia < both.high


def test_halving_moves_little_where_the_log_is_fine_enough() -> None:
    found = plain(dive(Turning(inertia=12.0), 1))
    known = intervals(found, [halved(found)])[INERTIA]
    assert known.high - known.low < 0.01 * known.value


@pytest.mark.parametrize("seed", [1, 2])
def test_the_gyros_noise_bends_nothing_because_starts_are_fitted(seed: int) -> None:
    """Windows of three samples, noise of a fifth of the motion: with starts as measured I is a fifth too small."""
    vehicle = Turning(inertia=12.0)
    log = dive(vehicle, seed, seconds=360.0, noise=0.06)
    found = plain(log)
    short = fit(found.structure, found.theta, Problem(cut([log], found.structure, 0.1, 0.3)), rounds=30)
    rate = 0.4
    drag = short.theta[LINEAR] * rate + short.theta[QUADRATIC] * rate**2
    assert drag == pytest.approx(vehicle.linear * rate + vehicle.quadratic * rate**2, rel=0.03)
    known = intervals(short)[INERTIA]
    assert known.low < vehicle.inertia < known.high < 1.1 * vehicle.inertia


@pytest.mark.parametrize(("linear", "quadratic"), [(25.0, -8.0), (-3.0, 40.0)])
def test_drag_is_never_negative(linear: float, quadratic: float) -> None:
    """Damping whose slope falls with the rate, or that drives at rest: the negative coefficient ends at its bound."""
    found = plain(dive(Turning(12.0, linear, quadratic), 1))
    assert found.theta[LINEAR if linear < 0.0 else QUADRATIC] == 0.0
    assert found.theta[QUADRATIC if linear < 0.0 else LINEAR] > 0.0


def anew(found: Fit) -> Array:
    """(windows,) the cost of each window by a fit without its fold."""
    fold, cost = folds(found.problem.windows), found.cost.copy()
    for k in np.unique(fold):
        own = fold == k
        without = fit(found.structure, found.theta, found.problem.without(own), found.starts)
        cost[own] = costs_of(without.error, found.scale, found.problem, without.starts)[own]
    return cost


def test_one_step_excludes_a_fold_about_as_a_fit_without_it_does() -> None:
    found = plain(dive(QUICK, 1))
    straight = replace(found.structure, rows=damping("yaw_rate")[:1])
    lesser = fit(straight, found.theta, found.problem, found.starts)
    windows = found.problem.windows
    one_step, exact = left_out(found), anew(found)
    assert exact.sum() > found.cost.sum()
    assert np.corrcoef(one_step - found.cost, exact - found.cost)[0, 1] > 0.95
    quick, slow = gain(left_out(lesser) - one_step, windows), gain(anew(lesser) - exact, windows)
    assert slow.rest > 0.5 * slow.total > 0.0
    assert quick.total == pytest.approx(slow.total, rel=0.01)
    assert quick.rest == pytest.approx(slow.rest, rel=0.01)
