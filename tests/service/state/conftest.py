"""What the tests of durable state share: the iterations of a learner without a bus, and how they are saved."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from service.learner.node import LearnerNode
from service.learner.prepared_iteration import CommittedIteration
from service.state.store import Store
from service.wire import encode
from simulator import leng
from tests.service.conftest import configured


@cache
def _iterations() -> list[CommittedIteration]:
    """Three iterations."""
    node = LearnerNode(configured(), boot="b")
    for name, (t, value) in leng.recording("T1", seed=2).streams().items():
        node.push(name, t[t < 100.0], value[t < 100.0])
    found = []
    while (outcome := node.learn()) is not None:
        found.append(outcome)
    return found


def save(store: Store, outcome: CommittedIteration, memory: dict[str, Any] | None = None) -> None:
    """As the learner saves an iteration; with another memory where it is given."""
    model = outcome.snapshot
    store.save(memory or outcome.memory, model.revision, model.t, encode(model), encode(outcome.report))


@pytest.fixture
def outcomes() -> list[CommittedIteration]:
    return _iterations()
