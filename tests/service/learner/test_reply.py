"""The reply to the most frequent question, written without objects between, beside the usual way."""

from __future__ import annotations

import pytest

from incsvr.learning.learner import Settings
from service import wire
from service.learner.published import ServedModel, damping_reply
from service.learner.questions import DampingQuery
from tests.incsvr.learning import among_others, run, stream


@pytest.fixture(scope="module")
def served() -> ServedModel:
    return ServedModel(run(Settings(), stream(1, 600))[0].model, 7, 12, 1.0)


def test_it_says_what_the_usual_way_says(served: ServedModel) -> None:
    for rate in (-0.2, -1e-7, 0.0, 0.1, 0.2345678901234567):
        quick = served.reply_to(f"rate={rate!r}")
        assert quick is not None
        assert wire.decode(wire.DampingReply, quick) == damping_reply(served.model, DampingQuery((rate,)), 12, 7)


@pytest.mark.parametrize("parameters", ["", "rate=", "rate=0.1,0.2", "rate=0.1;at=3", "rate=0_1", "rate=nan", "rate=1"])
def test_all_else_is_left_to_the_usual_way(served: ServedModel, parameters: str) -> None:
    assert served.reply_to(parameters) is None


def test_over_several_velocities_and_before_anything_is_learned_the_usual_way_answers() -> None:
    several = Settings(others=("sway", "surge"))
    model = run(several, among_others(stream(1, 100)))[0].model
    assert ServedModel(model, 1, 2, 1.0).reply_to("rate=0.1") is None
    untrained = run(Settings(), stream(1, 0))[0].model
    assert ServedModel(untrained, 0, 0, None).reply_to("rate=0.1") is None
