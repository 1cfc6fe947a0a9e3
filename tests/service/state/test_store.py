"""Durable state: all of an iteration or nothing, and never somebody else's."""

from __future__ import annotations

import logging
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.errors import BadInput
from service import wire
from service.config.configuration import Config
from service.learner.node import LearnerNode
from service.recordings.recording import Recording, from_table
from service.state.history import NotKept
from service.state.store import Store
from service.wire import encode
from simulator import leng
from tests.service.conftest import PATIENCE, StartBench, configured, cut
from tests.service.state.conftest import Saved, save

MANY = 10**9


def test_what_was_saved_is_found_again(tmp_path: Path, outcomes: list[Saved]) -> None:
    store = Store(tmp_path, configured())
    assert store.memory is None
    for outcome in outcomes:
        save(store, outcome)
    store.close()
    again = Store(tmp_path, configured())
    assert again.notices == ()
    assert again.memory == outcomes[-1].memory
    assert again.history.revision(2).snapshot == encode(outcomes[1].snapshot)
    assert again.history.at((outcomes[1].snapshot.t or 0.0) + 0.1) == again.history.revision(2)
    with pytest.raises(NotKept, match="no model is kept"):
        again.history.at(-1.0)
    assert again.history.reports(0, 10, MANY) == [encode(outcome.report) for outcome in outcomes]
    assert again.history.reports(0, 10, 1) == [encode(outcomes[0].report)]
    again.close()


def test_a_learner_that_takes_up_its_memory_goes_on_to_the_bit(outcomes: list[Saved]) -> None:
    config = configured()
    streams = leng.recording("T1", seed=2).streams()
    node = LearnerNode(config, boot="b")
    snapshots = []
    for start in range(0, 100, 7):
        # Written down and taken up again every seven seconds, wherever a batch or a window happens to be.
        node = LearnerNode(config, boot="b", memory=node.memory(whole=True))
        for name, (t, value) in streams.items():
            part = (t >= start) & (t < min(start + 7, 100))
            node.push(name, t[part], value[part])
        while (outcome := node.learn()) is not None:
            snapshots.append(outcome.served)
    assert snapshots == [outcome.snapshot for outcome in outcomes]


def test_under_other_signal_settings_the_streams_begin_anew() -> None:
    streams = leng.recording("T1", seed=2).streams()

    def feed(node: LearnerNode, first: float, last: float) -> None:
        for name, (t, value) in streams.items():
            part = (t >= first) & (t < last)
            node.push(name, t[part], value[part])

    node = LearnerNode(configured(), boot="b")
    feed(node, 0.0, 20.0)
    again = LearnerNode(configured(signals__sample_period=0.3), boot="b", memory=node.memory(whole=True))
    feed(again, 20.0, 40.0)
    outcome = again.learn()
    assert outcome is not None
    steps = np.diff(outcome.report.batch.time)
    assert {round(step, 1) for step in steps if step < 1.0} == {0.6, 0.3}


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"vehicle__name": "other"}, "vehicle leng, and now vehicle is other"),
        ({"vehicle__inertia": 360.0}, "inertia 350.0, and now inertia is 360.0"),
        ({"learner__gamma": 20.0}, "gamma 10.0, and now gamma is 20.0"),
    ],
)
def test_another_vehicles_state_is_set_aside(
    tmp_path: Path, outcomes: list[Saved], change: dict[str, Any], names: str
) -> None:
    store = Store(tmp_path, configured())
    save(store, outcomes[0])
    store.close()
    other = Store(tmp_path, configured(**change))
    assert other.memory is None
    (said,) = other.notices
    assert names in said
    assert "yaw.refused-1.sqlite" in said
    assert other.history.reports(0, 10, MANY) == []
    other.close()
    set_aside = sqlite3.connect(tmp_path / "leng" / "yaw.refused-1.sqlite")
    assert set_aside.execute("SELECT count(*) FROM history").fetchone() == (1,)
    set_aside.close()


def test_a_state_of_the_other_policy_goes_on(
    caplog: pytest.LogCaptureFixture, start: StartBench, run: Recording, tmp_path: Path
) -> None:
    """Its history, its revisions and its model go on, and health says it without a warning."""
    first = start(state=tmp_path, learner__policy="paper")
    models = first.follow(first.keys.model, wire.ModelSnapshot)
    first.play(cut(run, 70.0))
    before = [models.get(timeout=PATIENCE) for _ in range(2)][-1]
    first.stop()
    caplog.clear()
    second = start(state=tmp_path)
    payload, _ = second.get(second.keys.model)
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload).support == before.support
    models = second.follow(second.keys.model, wire.ModelSnapshot)
    (remark,) = second.host.node.remarks
    assert remark.startswith("revision 2 was learned with policy paper; its 60 vectors are")
    assert remark in second.health().reasons
    assert not [each for each in caplog.records if each.levelno >= logging.WARNING]
    late = run.time >= 70.0
    second.play(from_table(run.name, run.time[late], {name: values[late] for name, values in run.columns.items()}))
    assert models.get(timeout=PATIENCE).revision == 3
    assert second.get(f"{second.keys.model}?revision=1")[0] is not None


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    config: Config = configured()
    with pytest.raises(BadInput, match="is no directory; set `state` to another directory"):
        Store(tmp_path / "file" / "state", config)


def test_a_state_is_one_learners_until_it_ends(tmp_path: Path) -> None:
    config = configured(state=tmp_path)
    first = Store(tmp_path, config)
    with pytest.raises(BadInput, match="another learner has the state"):
        Store(tmp_path, config)
    other = Store(tmp_path, configured(state=tmp_path, prefix="leng/pitch"))
    other.close()
    first.close()
    Store(tmp_path, config).close()


def test_where_effects_change_while_it_learns_the_memory_says_with_which_it_was_learned(
    tmp_path: Path, outcomes: list[Saved]
) -> None:
    plain = Store(tmp_path, configured())
    save(plain, outcomes[0])
    plain.close()
    changing = Store(tmp_path, configured(), changing=True)
    assert changing.notices == ()
    changing.save_memory({**outcomes[0].memory, "effects": "torque_lag (1234)"})
    changing.close()
    again = Store(tmp_path, configured(), changing=True)
    assert again.notices == ()
    assert again.memory == {**outcomes[0].memory, "effects": "torque_lag (1234)"}
    again.close()
    off = Store(tmp_path, configured())
    assert "it was learned with effects torque_lag (1234), and now effects is None" in off.notices[0]
    off.close()


def test_a_state_learned_with_the_effects_of_a_file_is_none_for_effects_that_change(
    tmp_path: Path, outcomes: list[Saved]
) -> None:
    filed = Store(tmp_path, configured(), "torque_lag (1234)")
    save(filed, outcomes[0])
    filed.close()
    changing = Store(tmp_path, configured(), changing=True)
    assert "it was learned with effects torque_lag (1234)" in changing.notices[0]
    changing.close()
