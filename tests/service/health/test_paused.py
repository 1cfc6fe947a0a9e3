"""A learner whose sensor fails says so in its health, serves the last good model, and learns again by itself."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from service.health.health_watch import HealthConditions, HealthWatch
from service.learner.node import LearnerNode
from service.learner.prepared_iteration import CommittedIteration
from service.learner.questions import DampingQuery
from simulator import leng
from tests.service.conftest import configured

FROM, UNTIL = 200.0, 290.0
"""While the torque's sign is reversed [s]."""
RATES: Array = np.linspace(-0.22, 0.22, 45)


def play(node: LearnerNode, after: float, until: float) -> list[CommittedIteration]:
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


def health(node: LearnerNode) -> Any:
    config = configured()
    watch = HealthWatch(config.health, started=0.0, clock=lambda: 0.0)
    watch.observe(HealthConditions(paused=node.current_warnings.paused))
    return watch.report(node)


def error(node: LearnerNode) -> float:
    predicted = np.array(node.predict(DampingQuery(tuple(RATES.tolist()))).damping)
    return float(np.mean(np.abs(predicted - leng.damping(RATES))))


def test_learning_pauses_while_the_torque_is_reversed_and_goes_on_after() -> None:
    node = LearnerNode(configured(), boot="")
    good = play(node, 0.0, FROM)
    assert health(node).learning.state == "learning"
    (taken_back,) = play(node, FROM, 270.0)
    said = health(node)
    assert said.learning.state == "paused"
    assert "opposite directions" in said.learning.why
    assert any("opposite directions" in reason for reason in said.reasons)
    # what is served is what was learned before the batch that may have been touched, under a revision of its own
    assert taken_back.snapshot.revision == good[-1].snapshot.revision + 1
    assert taken_back.snapshot.support == good[-2].snapshot.support
    assert not taken_back.report.trained
    assert error(node) < 3.0
    assert play(node, 270.0, UNTIL) == []
    again = play(node, UNTIL, 400.0)
    assert health(node).learning.state == "learning"
    assert again[-1].report.trained
    assert error(node) < 3.0


@pytest.mark.slow
def test_a_pause_survives_a_restart() -> None:
    node = LearnerNode(configured(), boot="")
    play(node, 0.0, 270.0)
    memory = json.loads(json.dumps(node.memory(whole=True)))
    again = LearnerNode(configured(), boot="", memory=memory)
    assert again.served.model.to_dict() == node.served.model.to_dict()
    after, same = play(node, 270.0, 400.0), play(again, 270.0, 400.0)
    assert [each.snapshot for each in after] == [each.snapshot for each in same]
    assert after
