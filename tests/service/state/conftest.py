"""What the tests of durable state share: the iterations of a learner without a bus, and how they are saved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import pytest

from service.learner.node import LearnerNode
from service.state.store import Store
from service.wire import IterationReport, ModelSnapshot, encode
from simulator import leng
from tests.service.conftest import configured


@dataclass(frozen=True)
class Saved:
    """What is saved of an iteration."""

    snapshot: ModelSnapshot
    report: IterationReport
    memory: dict[str, Any]


@cache
def _iterations() -> list[Saved]:
    """Three iterations."""
    node = LearnerNode(configured(), boot="b")
    for name, (t, value) in leng.recording("T1", seed=2).streams().items():
        node.push(name, t[t < 100.0], value[t < 100.0])
    found = []
    while (outcome := node.learn()) is not None:
        found.append(Saved(outcome.served, outcome.report, node.memory()))
    return found


def save(store: Store, outcome: Saved, memory: dict[str, Any] | None = None) -> None:
    """As the learner saves an iteration; with another memory where it is given."""
    model = outcome.snapshot
    store.save(memory or outcome.memory, model.revision, model.t or 0.0, encode(model), encode(outcome.report))


@pytest.fixture
def outcomes() -> list[Saved]:
    return _iterations()
