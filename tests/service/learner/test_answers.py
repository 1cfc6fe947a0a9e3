"""The learner on a real bus: what it answers, from the newest model and from history."""

from __future__ import annotations

import queue
from pathlib import Path

import numpy as np
import pytest
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

from service import wire
from service.recordings.recording import Recording
from tests.service.conftest import PATIENCE, StartBench


def test_the_damping_query_answers_what_the_snapshot_says(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    for _ in range(3):
        snapshot = models.get(timeout=PATIENCE)
    rates = [-0.2, 0.0, 0.1, 3.0]
    expected = snapshot.model().predict(np.array(rates))
    asked = f"{bench.keys.damping}?rate={','.join(map(str, rates))}"
    for selector, payload in ((asked, None), (bench.keys.damping, b'{"rate": [-0.2, 0, 0.1, 3.0]}')):
        answer, _ = bench.get(selector, payload)
        assert answer is not None
        reply = wire.decode(wire.DampingReply, answer)
        assert reply.damping == tuple(expected.damping)
        assert reply.sigma == tuple(expected.sigma)
        assert reply.extrapolated == tuple(expected.extrapolated) == (False, False, False, True)
        assert (reply.iteration, reply.revision, reply.rate) == (3, 3, tuple(rates))
    kernel = np.exp(-snapshot.kernel.gamma * np.subtract.outer(rates[:3], snapshot.support.rate) ** 2)
    np.testing.assert_allclose(kernel @ snapshot.support.weight, expected.damping[:3], atol=1e-6)


def test_before_anything_is_learned_there_is_an_error_reply(start: StartBench) -> None:
    bench = start()
    for selector in (f"{bench.keys.damping}?rate=0.1", bench.keys.model):
        payload, error = bench.get(selector)
        assert payload is None
        assert error is not None
        assert error.error_type == "NothingLearned"
        assert "nothing has been learned yet" in error.error


@pytest.mark.parametrize(
    ("question", "names"),
    [
        ("", "name the yaw rates"),
        ("?rate=", "no list of numbers"),
        ("?rate=1,,2", "no list of numbers"),
        ("?rate=fast", "no list of numbers"),
        ("?rate=nan", "finite"),
        ("?rate=0.1,inf", "finite"),
        ("?rate=" + "1," * 100_000, "several queries"),
    ],
)
def test_a_bad_question_is_told_what_is_wrong(start: StartBench, question: str, names: str) -> None:
    bench = start()
    payload, error = bench.get(bench.keys.damping + question)
    assert payload is None
    assert error is not None
    assert error.error_type == "BadInput"
    assert names in error.error


def test_late_joiners_and_a_plain_get_have_the_latest_snapshot(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    for _ in range(3):
        latest = models.get(timeout=PATIENCE)
    late: queue.Queue[bytes] = queue.Queue()
    _follower = declare_advanced_subscriber(
        bench.session,
        bench.keys.model,
        lambda sample: late.put(sample.payload.to_bytes()),
        history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
    )
    assert wire.decode(wire.ModelSnapshot, late.get(timeout=PATIENCE)) == latest
    payload, _ = bench.get(bench.keys.model)
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload) == latest


def test_history_answers_by_time_and_by_revision(start: StartBench, run: Recording, tmp_path: Path) -> None:
    bench = start(state=tmp_path)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    published = [models.get(timeout=PATIENCE) for _ in range(3)]

    def ask(selector: str) -> wire.ModelSnapshot:
        payload, error = bench.get(bench.keys.model + selector)
        assert payload is not None, error
        return wire.decode(wire.ModelSnapshot, payload)

    assert ask("?revision=2") == published[1]
    assert ask(f"?at={published[1].t}") == published[1]
    assert ask(f"?at={published[2].t - 1e-3}") == published[1]
    assert ask("?at=1e9") == published[2]
    for selector, kind in (
        ("?at=0", "NotKept"),
        ("?revision=9", "NotKept"),
        ("?at=x", "BadInput"),
        ("?revision=-1", "BadInput"),
    ):
        _, error = bench.get(bench.keys.model + selector)
        assert error is not None
        assert error.error_type == kind
    payload, _ = bench.get(f"{bench.keys.iteration}?after=1")
    assert payload is not None
    history = wire.decode(wire.IterationHistory, payload)
    assert [report.iteration for report in history.iterations] == [2, 3]
    assert history.latest_revision == 3


def test_a_learner_without_a_state_answers_for_its_newest_revisions(start: StartBench, run: Recording) -> None:
    bench = start(state=None)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    published = [models.get(timeout=PATIENCE) for _ in range(3)]
    payload, _ = bench.get(f"{bench.keys.model}?revision=1")
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload) == published[0]
    payload, _ = bench.get(f"{bench.keys.iteration}?after=1")
    assert payload is not None
    assert [report.iteration for report in wire.decode(wire.IterationHistory, payload).iterations] == [2, 3]


def test_the_ledger_of_effects_answers_a_get(start: StartBench) -> None:
    bench = start()
    payload, _ = bench.get(bench.keys.effects)
    assert payload is not None
    assert wire.decode(wire.EffectsLedger, payload).effects == ()
