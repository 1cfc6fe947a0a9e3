"""Health: one level, and sentences that say why. The clock is the test's own."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from service.config.sections import HealthLimits
from service.health.health_watch import HealthConditions, HealthWatch
from service.learner.next_iteration import NextIteration
from service.learner.node import LearnerNode
from simulator import leng
from tests.service.conftest import configured


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def watch(clock: Clock) -> HealthWatch:
    return HealthWatch(HealthLimits(), started=clock(), clock=clock)


@pytest.fixture
def node() -> LearnerNode:
    return LearnerNode(configured(), boot="b")


def feed(watch: HealthWatch, node: LearnerNode, streams: dict[str, tuple[Array, Array]]) -> None:
    for name, (t, value) in streams.items():
        watch.add_values(name, t, value)
        node.push(name, t, value)


def moving(start: float, end: float) -> dict[str, tuple[Array, Array]]:
    t = np.arange(start, end, 0.02, dtype=np.float64)
    return {"yaw_rate": (t, np.array(0.1 * np.sin(t))), "torque": (t, np.array(20.0 * np.cos(t)))}


def test_a_velocity_that_does_not_come_stops_the_learning_and_is_named(clock: Clock) -> None:
    config = configured(vehicle__mass_matrix=[60.0, 80.0, 0.0, 0.0, 0.0, 350.0], signals__channels=["surge", "sway"])
    node = LearnerNode(config, boot="b")
    watch = HealthWatch(HealthLimits(), started=clock(), clock=clock, coupled=config.coupled())
    streams = moving(0.0, 20.0)
    feed(watch, node, {"surge": streams["yaw_rate"]} | streams)
    assert watch.report(node).level == "OK"  # it may still come
    clock.now += 11.0
    feed(watch, node, {"surge": moving(20.0, 31.0)["yaw_rate"]} | moving(20.0, 31.0))
    health = watch.report(node)
    assert health.reasons == ("sway does not arrive, and without it its terms of the mass matrix cannot be subtracted",)
    assert (health.level, health.counters["samples"]) == ("STALE", 0)
    assert (health.learning.state, health.learning.why) == (
        "starved",
        "samples wait 10 s for sway, which signals.channels lists and which does not arrive",
    )


def test_values_that_are_sent_together_are_said_to_be(watch: HealthWatch, node: LearnerNode, clock: Clock) -> None:
    """A second of the gyro at once, stamped as it is sent."""
    for second in range(12):
        streams = moving(float(second), second + 1.0)
        t, rate = streams["yaw_rate"]
        stamps: Array = second + 1.0 + 0.001 * np.arange(t.size, dtype=np.float64)
        feed(watch, node, {"torque": streams["torque"], "yaw_rate": (stamps, rate)})
        clock.now += 1.0
        health = watch.report(node)
    assert health.learning.state == "starved"
    assert "the yaw rate arrives in bursts 0.95 s apart, stamped when sent or written" in health.learning.why


def test_a_silent_stream_is_stale(watch: HealthWatch, node: LearnerNode, clock: Clock) -> None:
    assert watch.report(node).level == "OK"  # it may still come
    clock.now += 3.0
    assert watch.report(node).reasons == ("no yaw rate has arrived yet", "no torque has arrived yet")
    feed(watch, node, moving(0.0, 5.0))
    assert watch.report(node).level == "OK"
    clock.now += 2.5
    health = watch.report(node)
    assert health.level == "STALE"
    assert health.reasons[0] == "the last yaw rate arrived 2.5 s ago"


def test_rejected_values_warn_and_are_forgiven(watch: HealthWatch, node: LearnerNode, clock: Clock) -> None:
    feed(watch, node, moving(0.0, 5.0))
    watch.add_refusal("not_json")
    node.push("yaw_rate", np.array([5.0, np.nan]), np.array([50.0, 0.0]))
    health = watch.report(node)
    assert health.level == "WARN"
    assert "1 value rejected: not json" in health.reasons
    assert {name: health.counters[f"rejected:{name}"] for name in ("not_json", "implausible", "not_finite")} == {
        "not_json": 1,
        "implausible": 1,
        "not_finite": 1,
    }
    for step in range(1, 12):
        clock.now += 1.0
        feed(watch, node, moving(5.0 + step, 6.0 + step))
    assert watch.report(node).level == "OK"
    assert watch.report(node).counters["rejected"] == 3


def test_a_sensor_that_stands_still_warns(watch: HealthWatch, node: LearnerNode) -> None:
    t = np.arange(0.0, 4.0, 0.02, dtype=np.float64)
    feed(watch, node, {"yaw_rate": (t, np.where(t < 1.0, np.sin(t) / 5, 0.05)), "torque": (t, np.cos(t))})
    health = watch.report(node)
    assert health.level == "WARN"
    assert health.reasons == ("the yaw rate is constant at 0.05 rad/s for 3.0 s",)


def test_a_vehicle_beyond_the_learned_range_warns(watch: HealthWatch, node: LearnerNode) -> None:
    run = leng.recording("T1", seed=1).streams()
    feed(watch, node, {name: (t[t < 100.0], v[t < 100.0]) for name, (t, v) in run.items()})
    while node.learn() is not None:
        pass
    assert watch.report(node).reasons == ()
    t = np.arange(100.0, 110.0, 0.02, dtype=np.float64)
    noise = 0.001 * np.sin(50.0 * t)
    feed(watch, node, {"yaw_rate": (t, 0.6 + noise), "torque": (t, 90.0 + noise)})
    health = watch.report(node)
    assert health.level == "WARN"
    assert "where the model extrapolates (learned -0.2" in health.reasons[0]


@pytest.mark.slow
def test_a_vehicle_that_only_the_water_moves_is_told_and_the_model_stays(watch: HealthWatch, node: LearnerNode) -> None:
    """First the torque turns it, then the water alone, and the torque answers it."""
    t = np.arange(0.0, 70.0, 0.02, dtype=np.float64)
    drag, inertia = 150.0, node.config.vehicle.inertia
    turning = {"yaw_rate": (t, 0.1 * np.sin(t)), "torque": (t, 0.1 * (drag * np.sin(t) + inertia * np.cos(t)))}
    feed(watch, node, turning)
    while node.learn() is not None:
        pass
    assert not any("excitation" in reason for reason in watch.report(node).reasons)
    learned = node.served.model.predict(np.linspace(-0.1, 0.1, 5)).damping
    t = np.arange(70.0, 300.0, 0.02, dtype=np.float64)
    rate: Array = np.array(0.01 * np.sin(0.7 * t))
    feed(watch, node, {"yaw_rate": (t, rate), "torque": (t, -200.0 * rate)})
    while node.learn() is not None:
        pass
    health = watch.report(node)
    (said,) = (reason for reason in health.reasons if "the torque caused" in reason)
    assert said == f"learning is starved: {health.learning.why}"
    assert "rad/s" in said
    assert (health.level, health.learning.state) == ("WARN", "starved")
    now = node.served.model.predict(np.linspace(-0.1, 0.1, 5)).damping
    np.testing.assert_allclose(now, learned, atol=0.5)  # of 15 N m: the batch between the two holds a jump


def test_reversals_at_the_ends_of_the_learned_range_do_not_make_health_go_to_and_fro(
    watch: HealthWatch, node: LearnerNode, clock: Clock
) -> None:
    """In the paper's experiment each end is reached again and again, and noise and forgetting move what is learned."""
    streams = leng.recording("T1", 1).streams()
    said = []
    for second in range(220):
        for name, (t, value) in streams.items():
            now = (t >= second) & (t < second + 1.0)
            watch.add_values(name, t[now], value[now])
            node.push(name, t[now], value[now])
        while node.learn() is not None:
            pass
        clock.now += 1.0
        said.append(any("extrapolates" in reason for reason in watch.report(node).reasons))
    assert any(said[30:60]), "after the first batch the other direction is new to it"
    assert not any(said[70:])
    assert sum(before != after for before, after in pairwise(said)) == 2


def test_a_channel_that_an_effect_reads_must_come(watch: HealthWatch, node: LearnerNode, clock: Clock) -> None:
    watch.observe(HealthConditions(effect_channels=("sway",)))
    clock.now += 11.0
    feed(watch, node, moving(0.0, 5.0))
    assert watch.report(node).reasons == (
        "sway does not arrive, and without it the traced effects cannot be subtracted",
    )
    watch.add_values("sway", np.zeros(1), np.zeros(1))
    assert watch.report(node).level == "OK"


FROM, UNTIL = 200.0, 290.0
"""While the torque's sign is reversed [s]."""
RATES: Array = np.linspace(-0.22, 0.22, 45)


def played(node: LearnerNode, after: float, until: float) -> list[NextIteration]:
    """What is published while Leng's run is pushed from one time to another [s]."""
    for name, (t, value) in leng.recording("T1", 3).streams().items():
        if name == "torque":
            value = np.where((t >= FROM) & (t < UNTIL), -value, value)
        here = (t >= after) & (t < until)
        node.push(name, t[here], value[here])
    outcomes = []
    while (outcome := node.learn()) is not None:
        outcomes.append(outcome)
    return outcomes


def judged(node: LearnerNode) -> Any:
    config = configured()
    watch = HealthWatch(config.health, started=0.0, clock=lambda: 0.0)
    watch.observe(HealthConditions(paused=(node.current_warnings.paused,)))
    return watch.report(node)


def curve_error(node: LearnerNode) -> float:
    predicted = node.served.model.predict(RATES).damping
    return float(np.mean(np.abs(predicted - leng.damping(RATES))))


def test_learning_pauses_while_the_torque_is_reversed_and_goes_on_after() -> None:
    node = LearnerNode(configured(), boot="")
    good = played(node, 0.0, FROM)
    assert judged(node).learning.state == "learning"
    (taken_back,) = played(node, FROM, 270.0)
    said = judged(node)
    assert said.learning.state == "paused"
    assert "opposite directions" in said.learning.why
    assert any("opposite directions" in reason for reason in said.reasons)
    # what is served is what was learned before the batch that may have been touched, under a revision of its own
    assert taken_back.served.revision == good[-1].served.revision + 1
    assert taken_back.served.support == good[-2].served.support
    assert not taken_back.report.trained
    assert curve_error(node) < 3.0
    assert played(node, 270.0, UNTIL) == []
    again = played(node, UNTIL, 400.0)
    assert judged(node).learning.state == "learning"
    assert again[-1].report.trained
    assert curve_error(node) < 3.0
