"""A learner without samples says so within five seconds, with the cause and the cure. The clock is the test's own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from incsvr.numerics import Array
from service import wire
from service.health.health_watch import HealthWatch
from service.learner.node import LearnerNode
from tests.service.conftest import configured
from tests.worlds import slow

Clock = Callable[[Array], Array]


def right(t: Array) -> Array:
    return t


class Drive:
    """A learner whose streams come second by second; health is looked at twice a second, as the process does it."""

    def __init__(self, rate_period: float = 0.05, torque_period: float = 0.05, **settings: object) -> None:
        self.node = LearnerNode(configured(**settings), boot="b")
        self.now = 1000.0
        self.watch = HealthWatch(self.node.config.health, started=self.now, clock=lambda: self.now)
        self.begin = self.now
        self._periods = {"yaw_rate": rate_period, "torque": torque_period}

    def go(self, seconds: float, **clocks: Clock | None) -> list[wire.Health]:
        """Health over the next seconds; a stream's clock stamps it, None silences it."""
        found = []
        for _ in range(int(2 * seconds)):
            t0 = self.now - self.begin
            for name, period in self._periods.items():
                clock = clocks.get(name, right)
                t = np.arange(np.ceil(t0 / period - 1e-9), np.ceil((t0 + 0.5) / period - 1e-9)) * period
                if clock is not None and t.size:
                    value = np.asarray(0.1 * np.sin(t) if name == "yaw_rate" else 30.0 * np.cos(t))
                    self.watch.add_values(name, clock(t), value)
                    self.node.push(name, np.asarray(clock(t)), value)
            self.now += 0.5
            found.append(self.watch.report(self.node))
        return found


def starved(healths: list[wire.Health]) -> list[bool]:
    return [health.learning.state == "starved" for health in healths]


KINDS: dict[str, tuple[dict[str, object], dict[str, Clock], str]] = {
    "a clock an hour ahead": ({}, {"yaw_rate": lambda t: t + 3600.0}, "yaw rate waits for torque, whose stamps are 36"),
    "seconds since 1970": ({}, {"torque": lambda t: t + 1.764e9}, "torque waits for yaw rate, whose stamps are 1764"),
    "milliseconds": ({}, {"yaw_rate": lambda t: 1e3 * t, "torque": lambda t: 1e3 * t}, "look like milliseconds"),
    "one in milliseconds": ({}, {"torque": lambda t: 1e3 * t}, "stamps of torque look like milliseconds"),
    "begins at zero": ({}, {"yaw_rate": lambda t: t - 20.0}, "the clock of yaw rate restarted and shows"),
    "stands still": ({}, {"torque": lambda t: np.full(t.size, 19.9)}, "every torque is refused"),
    "a slow stream": (
        {"signals__gap": 0.2, "torque_period": 0.25},
        {},
        "torque arrives every 0.25 s, longer than the 0.2",
    ),
    "far too slow": (
        {"torque_period": 1.0},
        {},
        "torque arrives every 1 s, longer than the 0.488 s that are bridged",
    ),
    "jitter beyond the gap": (
        {"signals__gap": 0.2, "torque_period": 0.19},
        {"torque": lambda t: t + 0.08 * np.sin(1e3 * t)},
        "longer than the 0.2 s that are bridged",
    ),
}


@pytest.mark.parametrize(("settings", "clocks", "cause"), KINDS.values(), ids=KINDS.keys())
def test_the_cause_is_said_within_five_seconds(
    settings: dict[str, object], clocks: dict[str, Clock], cause: str
) -> None:
    drive = Drive(**settings)  # type: ignore[arg-type]
    if not settings:
        assert not any(starved(drive.go(20.0)))
    healths = drive.go(20.0, **clocks)
    first = starved(healths).index(True)
    assert first <= 10
    assert all(starved(healths[first:]))
    health = healths[-1]
    assert cause in health.learning.why
    assert f"learning is starved: {health.learning.why}" in health.reasons
    assert health.level == "WARN"
    assert health.learning.since == pytest.approx(20.0 if not settings else 0.0, abs=1.5)


@pytest.mark.parametrize("period", [0.02, 0.1, 0.25])
def test_a_stream_that_is_learned_from_is_not_starved(period: float) -> None:
    healths = Drive(torque_period=period).go(30.0)
    assert not any(starved(healths))
    warned = [reason for reason in healths[-1].reasons if "arrives every 0.25 s" in reason]
    assert bool(warned) == (period == 0.25)


def test_it_is_said_when_samples_are_made_again() -> None:
    drive = Drive()
    drive.go(20.0)
    assert starved(drive.go(10.0, torque=lambda t: t + 3600.0))[-1]
    healths = drive.go(10.0)
    assert not starved(healths)[-1]
    assert healths[-1].learning.since == pytest.approx(30.0, abs=3.0)
    assert healths[-1].learning.why == ""


def test_a_silent_stream_is_said_once() -> None:
    drive = Drive()
    drive.go(10.0)
    health = drive.go(10.0, torque=None)[-1]
    assert (health.level, health.learning.state) == ("STALE", "starved")
    assert health.learning.why.startswith("the last torque arrived")
    assert not [reason for reason in health.reasons if "starved" in reason]


def test_commands_that_hold_for_too_short_are_said_with_the_cure() -> None:
    signals = {"torque": "commanded", "smoothing": 0.3, "lateness": 0.0}
    node = LearnerNode(configured(vehicle={"inertia": 0.6, "rate_limit": 6.0}, signals=signals), boot="b")
    now = 1000.0
    watch = HealthWatch(node.config.health, started=now, clock=lambda: now)
    streams = slow(12, 0.2, changes=(0.8, 1.2), duration=20.0).streams()
    for begin in np.arange(0.0, 20.0, 0.5):
        for name, (time, value) in streams.items():
            part = (time >= begin) & (time < begin + 0.5)
            watch.add_values(name, time[part], value[part])
            node.push(name, time[part], value[part])
        now += 0.5
        health = watch.report(node)
    assert node.batches.samples_seen == 0
    assert (
        "no command is constant for the 2.2 s that a sample needs; set signals.smoothing below "
        "0.3" in health.learning.why
    )


def test_a_log_that_is_played_at_once_is_starved_by_its_own_time() -> None:
    """The wall's clock stands: ten seconds of data without a sample are the same at any speed."""
    node = LearnerNode(configured(), boot="b")
    watch = HealthWatch(node.config.health, started=1000.0, clock=lambda: 1000.0)
    states = []
    for begin in np.arange(0.0, 20.0, 0.5):
        ahead = 0.0 if begin < 10.0 else 3600.0
        t = np.arange(begin, begin + 0.5, 0.05)
        for name, clock in {"yaw_rate": t, "torque": t + ahead}.items():
            watch.add_values(name, clock, np.sin(t))
            node.push(name, clock, np.sin(t))
        states.append(watch.report(node).learning)
    assert [learning.state for learning in states[:20]] == ["learning"] * 20
    assert states[-1].state == "starved"
    assert "yaw rate, whose stamps are 36" in states[-1].why


def test_what_waits_to_be_taken_starves_nobody() -> None:
    """Health has heard of ten seconds of data that the learner takes only then."""
    node = LearnerNode(configured(), boot="b")
    watch = HealthWatch(node.config.health, started=1000.0, clock=lambda: 1000.0)
    for begin in np.arange(0.0, 40.0, 10.0):
        t = np.arange(begin, begin + 10.0, 0.05)
        for name in ("yaw_rate", "torque"):
            watch.add_values(name, t, np.sin(t))
        assert watch.report(node).learning.state == "learning"
        for name in ("yaw_rate", "torque"):
            node.push(name, t, np.sin(t))
        assert watch.report(node).learning.state == "learning"
