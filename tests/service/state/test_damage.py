"""What happens to a state between two starts: it is never wrong without a word."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service import wire
from service.state.history import NotKept
from service.state.state_file import StateFile
from service.state.store import Store
from tests.service.conftest import PATIENCE, Bench, StartBench, configured, teach
from tests.service.state.conftest import Saved, save


@pytest.fixture
def state(tmp_path: Path, outcomes: list[Saved]) -> Path:
    """The file of a learner that published three revisions and was killed."""
    store = Store(tmp_path, configured())
    for outcome in outcomes:
        save(store, outcome)
    store.close()
    return store.path


def test_after_any_flipped_bit_what_is_read_is_what_was_written_or_it_is_said(
    tmp_path: Path, state: Path, outcomes: list[Saved]
) -> None:
    whole = state.read_bytes()
    random = np.random.default_rng(1)
    told = 0
    for place in random.integers(len(whole), size=80):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << random.integers(8)
        for leftover in tmp_path.glob("leng/*"):
            leftover.unlink()
        state.write_bytes(damaged)
        store = Store(tmp_path, configured())
        try:
            assert store.memory == outcomes[-1].memory or (store.memory is None and store.notices)
            if store.memory is not None:
                for outcome in outcomes:
                    try:
                        found = store.history.revision(outcome.snapshot.revision)
                        assert found.snapshot == wire.encode(outcome.snapshot)
                        assert found.report == wire.encode(outcome.report)
                        assert store.history.at(outcome.snapshot.t or 0.0) == found
                    except NotKept:
                        assert store.notices
            told += bool(store.notices)
        finally:
            store.close()
    assert told > 40


def replaced(content: bytes) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(content)


def halved(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def removed_but_for_its_log(path: Path) -> None:
    path.rename(path.with_name(path.name + "-wal"))
    path.with_suffix(".lock").unlink()


def a_directory(path: Path) -> None:
    path.unlink()
    path.mkdir()


def changed(statement: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        with sqlite3.connect(path) as connection:
            connection.execute(statement)
        connection.close()

    return change


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (replaced(b""), "power cut"),
        (Path.unlink, "it is missing"),
        (removed_but_for_its_log, "it is missing"),
        (halved, "damaged"),
        (replaced(b"not a database at all, but long enough to have a header"), "damaged"),
        (replaced(bytes(5000)), "damaged"),
        (a_directory, "a directory is in its place"),
        (changed("UPDATE memory SET value = '{}'"), "checksum"),
        (changed("UPDATE memory SET value = replace(CAST(value AS TEXT), '1', '2')"), "checksum"),
        (changed("DELETE FROM memory"), "its memory is missing"),
        (changed("UPDATE identity SET value = '[9, 9]' WHERE name = 'form'"), "checksum"),
        (changed("ALTER TABLE history ADD COLUMN more"), "its tables"),
        (changed("DROP TABLE history"), "its tables"),
    ],
)
def test_what_is_lost_or_damaged_is_said_and_the_learner_begins_anew(
    tmp_path: Path, state: Path, damage: Callable[[Path], object], said: str, outcomes: list[Saved]
) -> None:
    damage(state)
    left = state.read_bytes() if said == "damaged" else None
    store = Store(tmp_path, configured())
    assert store.memory is None
    (notice,) = store.notices
    assert left is None or state.with_name("yaw.refused-1.sqlite").read_bytes() == left
    assert said in notice
    assert "learning starts with an empty model" in notice
    save(store, outcomes[0])
    assert store.problem is None
    store.close()
    again = Store(tmp_path, configured())
    assert (again.memory, again.notices) == (outcomes[0].memory, ())
    again.close()


def test_a_changed_row_of_the_history_is_not_answered(tmp_path: Path, state: Path, outcomes: list[Saved]) -> None:
    changed("UPDATE history SET t = t + 1e6 WHERE revision = 2")(state)
    changed("DELETE FROM history WHERE revision = 1")(state)
    store = Store(tmp_path, configured())
    assert store.memory == outcomes[-1].memory
    for revision in (1, 2):
        with pytest.raises(NotKept):
            store.history.revision(revision)
    with pytest.raises(NotKept):
        store.history.at(outcomes[1].snapshot.t or 0.0)
    assert store.history.reports(0, 10, 10**9) == [wire.encode(outcomes[2].report)]
    assert {"revision 1 is damaged in the history", "revision 2 is damaged in the history"} <= set(store.notices)
    store.close()


def test_a_missing_row_is_not_answered_with_an_older_one(tmp_path: Path, state: Path, outcomes: list[Saved]) -> None:
    changed("DELETE FROM history WHERE revision = 2")(state)
    store = Store(tmp_path, configured())
    with pytest.raises(NotKept, match="revisions after 1 are lost"):
        store.history.at(outcomes[1].snapshot.t or 0.0)
    assert store.history.at(outcomes[2].snapshot.t or 0.0).revision == 3
    store.close()


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"revision": -5}, "revision is -5"),
        ({"covered": [None]}, "covered"),
        ({"t": "soon"}, "t: give a finite number"),
        ({"learner": {}}, "no"),
        ({"weight": 1e6}, "weight beyond C"),
        ({"weight": None}, "no number"),
        ({"gamma": 11.0}, "other settings"),
        ({"iterations": 1.5}, "iterations: give a whole number, not 1.5"),
        ({"form": 99}, "of this version"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else None,
)
def test_what_no_learner_can_have_written_is_not_taken_up(
    tmp_path: Path, start: StartBench, outcomes: list[Saved], part: dict[str, Any], said: str
) -> None:
    memory: dict[str, Any] = json.loads(json.dumps(outcomes[0].memory))
    for name, value in part.items():
        if name == "weight":
            memory["learner"]["model"]["weight"][0] = value
        elif name == "gamma":
            memory["learner"]["model"]["gamma"] = value
        else:
            (memory if name in memory else memory["learner"])[name] = value
    store = Store(tmp_path, configured())
    save(store, outcomes[0], memory)
    store.close()
    bench = start(state=tmp_path)
    reason = bench.health().reasons[0]
    assert "yaw.refused-1.sqlite" in reason
    assert said in reason
    assert bench.health().revision == 0


def test_after_a_start_with_wrong_settings_the_state_that_fits_comes_back(
    tmp_path: Path, state: Path, outcomes: list[Saved]
) -> None:
    Store(tmp_path, configured(vehicle__inertia=360.0)).close()
    wrong = Store(tmp_path, configured(vehicle__inertia=360.0))
    assert (wrong.memory, wrong.notices) == (None, ())
    save(wrong, outcomes[0])
    wrong.close()
    right = Store(tmp_path, configured())
    assert right.memory == outcomes[-1].memory
    assert "yaw.refused-1.sqlite fits and was restored" in right.notices[0]
    assert len(right.history.reports(0, 10, 10**9)) == 3
    right.close()
    wrong = Store(tmp_path, configured(vehicle__inertia=360.0))
    assert wrong.memory == outcomes[0].memory
    wrong.close()


def test_a_damaged_state_does_not_come_back(tmp_path: Path, state: Path) -> None:
    halved(state)
    Store(tmp_path, configured()).close()
    state.write_bytes(b"")
    store = Store(tmp_path, configured())
    assert store.memory is None
    store.close()


def test_an_empty_state_can_be_read_again(tmp_path: Path) -> None:
    Store(tmp_path, configured()).close()
    store = Store(tmp_path, configured())
    assert (store.memory, store.notices) == (None, ())
    store.close()
    assert StateFile(store.path).memory() is None


def taught(start: StartBench, state: Path) -> tuple[Bench, Any]:
    bench = start(state=state)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    teach(bench.session, bench.keys, 2, 0.0, 100.0)
    return bench, models


def health_with(bench: Bench, sentence: str) -> wire.Health:
    return bench.health_when(lambda health: sentence in " ".join(health.reasons))


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
