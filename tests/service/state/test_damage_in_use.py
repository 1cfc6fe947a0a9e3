"""What happens to a state while a learner has it in use: it is never wrong without a word."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import Any

import pytest

from service import wire
from service.state.store import Store
from tests.service.conftest import PATIENCE, Bench, StartBench, configured, teach


def taught(start: StartBench, state: Path) -> tuple[Bench, Any]:
    bench = start(state=state)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    teach(bench.session, bench.keys, 2, 0.0, 100.0)
    return bench, models


def health_with(bench: Bench, sentence: str) -> wire.Health:
    """Asks until a reason holds the sentence."""
    until = time.monotonic() + PATIENCE
    while sentence not in " ".join((health := bench.health()).reasons):
        assert time.monotonic() < until, health
    return health


def test_a_copy_of_the_one_file_holds_all_that_was_published(tmp_path: Path, start: StartBench) -> None:
    bench, models = taught(start, tmp_path / "state")
    latest = [models.get(timeout=PATIENCE) for _ in range(3)][-1]
    (tmp_path / "copy" / "leng").mkdir(parents=True)
    shutil.copy(tmp_path / "state" / "leng" / "yaw.sqlite", tmp_path / "copy" / "leng")
    store = Store(tmp_path / "copy", configured())
    assert wire.decode(wire.ModelSnapshot, store.history.revision(3).snapshot) == latest
    assert store.memory is not None
    assert store.memory["revision"] == 3
    store.close()
    assert bench.health().revision == 3


@pytest.mark.slow
def test_a_state_that_is_removed_while_it_runs_is_said_and_written_again(tmp_path: Path, start: StartBench) -> None:
    bench, models = taught(start, tmp_path / "state")
    published = [models.get(timeout=PATIENCE) for _ in range(3)]
    shutil.rmtree(tmp_path / "state")
    health_with(bench, "was removed while the learner ran, and was written again")
    bench.stop()
    store = Store(tmp_path / "state", configured())
    kept = [store.history.revision(number).snapshot for number in (1, 2, 3)]
    assert kept == [wire.encode(model) for model in published]
    assert store.memory is not None
    assert store.memory["revision"] == 3
    store.close()


@pytest.mark.slow
def test_a_state_that_is_damaged_while_it_runs_is_set_aside_and_learning_goes_on(
    tmp_path: Path, start: StartBench
) -> None:
    bench, models = taught(start, tmp_path)
    for _ in range(3):
        models.get(timeout=PATIENCE)
    state = tmp_path / "leng" / "yaw.sqlite"
    with state.open("r+b") as file:  # never shorter than it was: that would be told as removed
        file.write(b"\0" * state.stat().st_size)
    teach(bench.session, bench.keys, 2, 100.0, 140.0)
    assert models.get(timeout=PATIENCE).revision == 4
    health = health_with(bench, "was set aside as yaw.refused-1.sqlite while the learner ran")
    assert health.level == "WARN"
    bench.stop()
    store = Store(tmp_path, configured())
    assert store.memory is not None
    assert store.memory["revision"] == 4
    store.close()
