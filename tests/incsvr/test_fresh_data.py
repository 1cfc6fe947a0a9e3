"""Effects on trial: what fresh data say, and what follows from it."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.fresh_data import compare_on_fresh_data
from incsvr.compensation.proof import Proof
from incsvr.errors import BadInput
from incsvr.numerics import Streams
from incsvr.tracing.model import Effect, TracedModel
from simulator import leng
from tests.hidden import BIAS, LAG, TRUTH, lag, recording, trim


def effects(*named: Effect) -> Compensation:
    rate = np.linspace(-0.3, 0.3, 61)
    return Compensation.of(TracedModel(leng.INERTIA, rate, TRUTH(rate), named, 1.0, 0.3, 2.5, (0.0, 300.0)))


TRUE = effects(lag(LAG), trim(BIAS))


@pytest.fixture(scope="module")
def streams() -> Streams:
    return recording(5, 300.0).streams()


def compared(streams: Streams, without: Compensation | None, found: Compensation, closed: bool = True) -> Proof:
    return compare_on_fresh_data(streams, 200.0, without, found, closed)


@pytest.mark.parametrize("closed", [True, False])
def test_the_true_effects_are_promoted_and_stay(streams: Streams, closed: bool) -> None:
    found = compared(streams, None, TRUE, closed)
    assert found.turned
    assert found.error["after"]["free_run_rmse"] < 0.5 * found.error["before"]["free_run_rmse"]
    assert found.error["after"]["torque_rmse"] < 0.5 * found.error["before"]["torque_rmse"]
    assert (found.of_suspected(last=True), found.of_known()) == ("promoted", "kept")


def test_effects_that_the_vehicle_does_not_have_are_refused_and_withdrawn() -> None:
    straight = leng.recording("T1", seed=3).streams()
    late = effects(lag(1.5))
    found = compare_on_fresh_data(straight, 250.0, None, late, closed=False)
    assert (found.of_suspected(last=False), found.of_known()) == ("refused", "withdrawn")
    assert "the error of the free run is higher: torque" in found.sentence()


def test_effects_are_compared_with_those_in_force(streams: Streams) -> None:
    assert compared(streams, TRUE, TRUE).of_suspected(last=True) == "refused"
    assert compared(streams, effects(trim(BIAS)), TRUE).of_suspected(last=True) == "promoted"


def test_a_vehicle_that_lies_still_tells_nothing(streams: Streams) -> None:
    (t, rate), (when, torque) = streams["yaw_rate"], streams["torque"]
    still = {
        "yaw_rate": (t, np.where(t < 200.0, rate, 0.01 * rate)),
        "torque": (when, np.where(when < 200.0, torque, 0.0)),
    }
    found = compared(still, None, TRUE)
    assert not found.turned
    assert [found.of_suspected(last) for last in (False, True)] == ["waits", "refused"]
    assert found.of_known() == "kept"


def test_too_little_before_the_fresh_data_is_said(streams: Streams) -> None:
    with pytest.raises(BadInput, match="too few to learn the damping from"):
        compare_on_fresh_data(streams, 1.0, None, TRUE)
