"""The reply to the most frequent question, written without objects between, beside the usual way."""

from __future__ import annotations

import pytest

from incsvr.learning.learner import Settings
from incsvr.signals.samples import Samples
from service import wire
from service.learner.published import damping_reply, reply_to
from tests.incsvr.learning import among_others, run, stream


def of(settings: Settings, samples: Samples) -> wire.ModelSnapshot:
    return wire.ModelSnapshot(revision=7, iteration=12, t=1.0, inertia=350.0, model=run(settings, samples)[0].model)


@pytest.fixture(scope="module")
def served() -> wire.ModelSnapshot:
    return of(Settings(), stream(1, 600))


def test_it_says_what_the_usual_way_says(served: wire.ModelSnapshot) -> None:
    for rate in (-0.2, -1e-7, 0.0, 0.1, 0.2345678901234567):
        quick = reply_to(served, f"rate={rate!r}")
        assert quick is not None
        assert wire.decode(wire.DampingReply, quick) == damping_reply(served, wire.DampingQuery((rate,)))


@pytest.mark.parametrize("parameters", ["", "rate=", "rate=0.1,0.2", "rate=0.1;at=3", "rate=0_1", "rate=nan", "rate=1"])
def test_all_else_is_left_to_the_usual_way(served: wire.ModelSnapshot, parameters: str) -> None:
    assert reply_to(served, parameters) is None


def test_over_several_velocities_and_before_anything_is_learned_the_usual_way_answers() -> None:
    several = Settings(others=("sway", "surge"))
    assert reply_to(of(several, among_others(stream(1, 100))), "rate=0.1") is None
    assert reply_to(of(Settings(), stream(1, 0)), "rate=0.1") is None
