"""The search names what acts, and nothing where nothing does."""

from __future__ import annotations

from dataclasses import replace

import pytest

from incsvr.model.fitting import Problem, fit
from incsvr.model.identification import identify, plain_fit, pool, structure_of
from incsvr.model.predictor import predictor
from incsvr.model.rows import free_products
from incsvr.model.search import drives, search
from incsvr.model.windows import cut
from incsvr.numerics import Streams
from tests.incsvr.model.turning import Turning, dive, steered
from tests.worlds import planar

CROSS_FLOW = "cross_flow:surge@yaw_rate"


def log(seed: int, cross_flow: float) -> Streams:
    return dive(Turning(inertia=12.0, cross_flow=cross_flow), seed, seconds=60.0, rate=5.0)


def test_one_round_names_cross_flow_among_a_few() -> None:
    runs = [log(1, 12.0)]
    found = plain_fit(structure_of(runs, ["yaw_rate"], ["surge"]), runs)
    few = {key: rows for key, rows in pool(found.structure, runs).items() if key.startswith(("cross_flow", "cubic"))}
    named = search(predictor(found, runs), few, most=1)
    assert [each.name for each in named.added] == [CROSS_FLOW]
    assert named.fit.theta[CROSS_FLOW] == pytest.approx(12.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_cross_flow_alone_is_named_among_all_effects(seed: int) -> None:
    found = identify([log(seed, 12.0)], ["yaw_rate"]).found
    assert [each.name for each in found.added] == [CROSS_FLOW]
    assert found.fit.theta[CROSS_FLOW] == pytest.approx(12.0, rel=0.1)


@pytest.mark.parametrize("seed", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_nothing_is_named_where_nothing_acts(seed: int) -> None:
    found = identify([log(seed, 0.0)], ["yaw_rate"]).found
    assert found.added == ()


@pytest.mark.parametrize("gain", [15.0, pytest.param(40.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("seed", [3, 4])
def test_nothing_is_named_where_a_controller_answers_the_water(seed: int, gain: float) -> None:
    """The water turns the vehicle by some 0.02 rad/s, seven times the gyro's noise, and the torque answers that."""
    found = identify([steered(Turning(), seed, gain=gain)], ["yaw_rate"]).found
    assert found.added == ()


def test_products_of_velocities_may_not_feed_a_vehicle() -> None:
    """As C(ν) of a mass matrix they take from one axis what they give to another; two of one sign give to both."""
    runs = [planar(3, 60.0).streams()]
    structure = replace(structure_of(runs, ["surge", "sway", "yaw_rate"]), tied=False)
    structure = structure.plus(rows=free_products(structure.axes))
    still = dict.fromkeys(structure.names, 0.0) | {f"mass:{axis}": 5.0 for axis in structure.axes}
    problem = Problem(cut(runs, structure, 0.1, 5.0))

    def fed(to_sway: float, to_yaw: float) -> str:
        products = {"coriolis:surge*yaw_rate@sway": to_sway, "coriolis:surge*sway@yaw_rate": to_yaw}
        return drives(fit(structure, still | {"linear@yaw_rate": 10.0} | products, problem, rounds=0))

    assert fed(500.0, -500.0) == ""
    assert fed(500.0, 500.0) in ("sway", "yaw_rate")
    tied = replace(structure, tied=True, rows=structure_of(runs, structure.axes).rows)
    assert not {row.key for row in free_products(structure.axes)} & set(pool(tied, runs))
