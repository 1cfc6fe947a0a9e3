"""The learner on a real bus: what it answers, from the newest model and from history."""

from __future__ import annotations

import queue
from typing import Any

import numpy as np
import pytest
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

from service import wire
from service.bus.ingest import MAX_PAYLOAD_BYTES
from service.recordings.recording import Recording
from tests.service.conftest import PATIENCE, Bench, StartBench, Taught


def test_the_damping_query_answers_what_the_snapshot_says(taught: Taught) -> None:
    bench, snapshot = taught.bench, taught.models[-1]
    rates = [-0.2, 0.0, 0.1, 3.0]
    expected = snapshot.model.predict(np.array(rates))
    asked = f"{bench.keys.damping}?rate={','.join(map(str, rates))}"
    for selector, payload in ((asked, None), (bench.keys.damping, b'{"rate": [-0.2, 0, 0.1, 3.0]}')):
        answer, _ = bench.get(selector, payload)
        assert answer is not None
        reply = wire.decode(wire.DampingReply, answer)
        assert reply.damping == tuple(expected.damping)
        assert reply.sigma == tuple(expected.sigma)
        assert reply.doubt == tuple(expected.doubt)
        assert reply.derivative == tuple(expected.derivative)
        assert reply.extrapolated == tuple(expected.extrapolated) == (False, False, False, True)
        assert (reply.iteration, reply.revision, reply.rate) == (3, 3, tuple(rates))
    kernel = np.exp(-snapshot.model.gamma * np.subtract.outer(rates[:3], snapshot.support.rate) ** 2)
    np.testing.assert_allclose(kernel @ snapshot.support.weight, expected.damping[:3], atol=1e-6)


def test_before_anything_is_learned_there_is_an_error_reply(untaught: Bench) -> None:
    for key in (f"{untaught.keys.damping}?rate=0.1", untaught.keys.model, untaught.keys.coefficients):
        payload, error = untaught.get(key)
        assert payload is None
        assert error is not None
        assert error.error_type == "NothingLearned"
        assert "nothing has been learned yet" in error.error


@pytest.mark.parametrize(
    ("question", "payload", "names"),
    [
        ("damping", None, "name the yaw rates"),
        ("damping?rate=", None, "no list of numbers"),
        ("damping?rate=1,,2", None, "no list of numbers"),
        ("damping?rate=fast", None, "no list of numbers"),
        ("damping?rate=nan", None, "finite"),
        ("damping?rate=0.1,inf", None, "finite"),
        ("damping?rate=" + "1," * 100_000, None, "several queries"),
        ("damping", b" " * (MAX_PAYLOAD_BYTES + 1), "several queries"),
        ("damping?rate=1e308", None, "beyond 1000 rad/s"),
        ("damping", b'{"rate": [0.1, 1e308]}', "beyond 1000 rad/s"),
        ("damping", b'{"rate": [1' + b"0" * 4299 + b"]}", "rate"),
        ("damping", b'{"rate": [' + b"0.1," * 5000 + b"0.1]}", "several queries"),
        ("damping?rate=0.1;revison=1", None, "revison= is no parameter"),
        ("damping?rate=0.1;rate=0.2", None, "given twice"),
        ("damping?rate=0.1", b'{"rate": [0.2]}', "not for both"),
        ("model?revision=1;at=2", None, "not for both"),
        ("model?revision=" + "9" * 4300, None, "no whole number"),
        ("model?revision=-1", None, "no whole number"),
        ("model?at=x", None, ""),
        ("iteration?revision=1;after=0", None, "not for both"),
        ("iteration?after=-1", None, "no whole number"),
        ("health?rate=1", None, "ask without parameters"),
    ],
    ids=lambda value: value[:40] if isinstance(value, str) else None,
)
def test_a_bad_question_is_told_what_is_wrong(
    untaught: Bench, question: str, payload: bytes | None, names: str
) -> None:
    answer, error = untaught.get(f"{untaught.keys.prefix}/{question}", payload)
    assert answer is None
    assert error is not None
    assert error.error_type == "BadInput"
    assert names in error.error


def test_late_joiners_and_a_plain_get_have_the_latest_snapshot(taught: Taught) -> None:
    bench, latest = taught.bench, taught.models[-1]
    late: queue.Queue[bytes] = queue.Queue()
    follower: Any = declare_advanced_subscriber(
        bench.session,
        bench.keys.model,
        lambda sample: late.put(sample.payload.to_bytes()),
        history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
    )
    assert wire.decode(wire.ModelSnapshot, late.get(timeout=PATIENCE)) == latest
    follower.undeclare()
    payload, _ = bench.get(bench.keys.model)
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload) == latest


def test_history_answers_by_time_and_by_revision(taught: Taught) -> None:
    bench, published = taught.bench, taught.models

    def ask(selector: str) -> wire.ModelSnapshot:
        payload, error = bench.get(bench.keys.model + selector)
        assert payload is not None, error
        return wire.decode(wire.ModelSnapshot, payload)

    assert ask("?revision=2") == published[1]
    assert ask(f"?at={published[1].t}") == published[1]
    assert ask(f"?at={(published[2].t or 0.0) - 1e-3}") == published[1]
    assert ask("?at=1e9") == published[2]
    for selector in ("?at=0", "?revision=9"):
        _, error = bench.get(bench.keys.model + selector)
        assert error is not None
        assert error.error_type == "NotKept"
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
