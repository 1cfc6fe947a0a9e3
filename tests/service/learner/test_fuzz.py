"""Any bytes on any key, over the real bus: counted by reason, nothing learned from it, nothing crashes."""

from __future__ import annotations

import json
import queue
from collections.abc import Iterator

import pytest
import zenoh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from service import wire
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.learner.node import LearnerNode
from simulator import leng
from tests.service.conftest import PATIENCE, Bench, configured, teach

JSON = zenoh.Encoding.APPLICATION_JSON

CORPUS = [
    (b"", "not_json"),
    (b"{", "not_json"),
    (b"\x00\xff\xfe\x80", "not_json"),
    (b'{"t": 39.5, "value": 0.1', "not_json"),
    ('{"t": 39.5, "value": 0.1}'.encode("utf-16"), "not_json"),
    (b"[" * 100_000, "not_json"),
    (b'{"t": 01, "value": 1}', "not_json"),
    (b"null", "wrong_form"),
    (b"17", "wrong_form"),
    (b"[1.0, 0.1]", "wrong_form"),
    (b'{"t": 39.5}', "wrong_form"),
    (b'{"value": 1.0}', "wrong_form"),
    (b'{"t": "1.0", "value": 0.1}', "wrong_type"),
    (b'{"t": 39.5, "value": null}', "wrong_type"),
    (b'{"t": true, "value": 0.1}', "wrong_type"),
    (b'{"t": 39.5, "value": {"x": 1}}', "wrong_type"),
    (b'{"t": 39.5, "value": [0.1]}', "wrong_type"),
    (b'{"t": [1.0, "x"], "value": [0.1, 0.2]}', "wrong_type"),
    (b'{"t": [[1.0]], "value": [[0.1]]}', "wrong_type"),
    (b'{"t": 39.5, "value": 0.1, "seq": 1.5}', "wrong_type"),
    (b'{"t": 39.5, "value": 0.1, "seq": -1}', "implausible_seq"),
    (b'{"t": 39.5, "value": 0.1, "seq": 1' + b"0" * 4299 + b"}", "implausible_seq"),
    (b'{"t": [1.0, 2.0], "value": [0.1]}', "unequal_length"),
    (b'{"t": 39.5, "value": NaN}', "not_finite"),
    (b'{"t": Infinity, "value": 0.1}', "not_finite"),
    (b'{"t": 39.5, "value": 1e999}', "not_finite"),
    (b'{"t": 39.5, "value": 1' + b"0" * 4000 + b"}", "not_finite"),
    (b'{"t": 39.5, "value": 1e300}', "implausible"),
    (b'{"t": 39.5, "value": 57.3}', "implausible"),
    (b'{"t": -1.0, "value": 0.1}', "negative_time"),
    (b'{"t": 1e12, "value": 0.1}', "implausible_time"),
    (b'{"t": 39.5, "value": 0.1}' + b" " * 10_000_000, "too_large"),
]


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    """A learner that has learned a little, and goes through all tests of this file."""
    endpoint = free_endpoint()
    with (
        open_session(listener_config_at(endpoint)) as server,
        open_session(client_config_at(endpoint), PATIENCE) as client,
    ):
        host = Host(server, configured())
        with WorkerThreads([host]) as crew:
            bench = Bench(host, [host], client, host.keys, lambda: crew.__exit__(None, None, None))
            models = bench.follow(bench.keys.model, wire.ModelSnapshot)
            teach(bench.session, bench.keys, 4, 0.0, 40.0)
            assert models.get(timeout=PATIENCE).iteration == 1
            yield bench


def rejected(bench: Bench, reason: str) -> int:
    return bench.health().counters.get(f"rejected:{reason}", 0)


def wait_for(bench: Bench, reason: str, count: int) -> None:
    """Asks until so many are counted."""
    found = bench.health_when(lambda health: health.counters.get(f"rejected:{reason}", 0) >= count)
    assert found.counters[f"rejected:{reason}"] == count


@pytest.mark.parametrize(("payload", "reason"), CORPUS, ids=[f"{n}-{reason}" for n, (_, reason) in enumerate(CORPUS)])
def test_each_known_fault_is_counted_by_its_reason(bench: Bench, payload: bytes, reason: str) -> None:
    before = rejected(bench, reason)
    bench.session.put(bench.keys.rate, payload, encoding=JSON)
    wait_for(bench, reason, before + 1)
    assert bench.host.node.served.iteration == 1


def test_what_is_no_json_by_its_encoding_is_counted(bench: Bench) -> None:
    bench.session.put(bench.keys.torque, b'{"t": 1.0, "value": 0.1}', encoding=zenoh.Encoding.IMAGE_PNG)
    wait_for(bench, "wrong_encoding", 1)
    bench.session.delete(bench.keys.torque)
    wait_for(bench, "no_put", 1)
    bench.session.put(f"{bench.keys.prefix}/channel/{'x' * 100}", b'{"t": 1.0, "value": 0.1}')
    wait_for(bench, "wrong_channel_name", 1)


def test_one_wrong_stamp_does_not_deafen_a_stream(bench: Bench) -> None:
    before = rejected(bench, "clock_jump")
    bench.session.put(bench.keys.rate, wire.measurement(1e9, 0.1))
    bench.session.put(bench.keys.rate, wire.measurement(35.0, 0.1))  # late: it is refused as well
    wait_for(bench, "clock_jump", before + 1)


numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.integers(), st.none(), st.booleans(), st.text(max_size=5)
)
BAD = st.one_of(
    st.binary(max_size=200),
    st.text(max_size=200).map(str.encode),
    # The right form, but a value that no vehicle has, in one message or in many.
    st.builds(lambda t, v: json.dumps({"t": t, "value": v}).encode(), numbers, st.sampled_from([1e9, "x", None, 2.0])),
    st.builds(
        lambda t, v: json.dumps({"t": t, "value": [2.0 + abs(x) for x in v]}).encode(),
        st.lists(numbers, max_size=20),
        st.lists(st.integers(0, 10**6), max_size=20),
    ),
    st.dictionaries(st.sampled_from(["t", "valu", "seq", "x"]), numbers).map(lambda d: json.dumps(d).encode()),
)


@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
@given(payloads=st.lists(BAD, min_size=1, max_size=5), key=st.sampled_from(["rate", "model", "damping", "health", "x"]))
def test_any_bytes_on_any_key_teach_nothing(bench: Bench, payloads: list[bytes], key: str) -> None:
    for payload in payloads:
        bench.session.put(f"{bench.keys.prefix}/{key}", payload)
    answer, error = bench.get(f"{bench.keys.damping}?rate=0.1")
    assert error is None
    assert answer is not None
    assert wire.decode(wire.DampingReply, answer).iteration == 1


@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
@given(text=st.text(st.characters(codec="utf-8", exclude_characters="#\0"), max_size=50), payload=st.none() | BAD)
def test_any_question_is_answered_or_told_what_is_wrong(bench: Bench, text: str, payload: bytes | None) -> None:
    for selector in (f"{bench.keys.damping}?rate={text}", f"{bench.keys.damping}?{text}"):
        answer, error = bench.get(selector, payload)
        if answer is not None:
            assert wire.decode(wire.DampingReply, answer).iteration == 1
        else:
            assert error is not None
            assert error.error_type == "BadInput"
            assert len(error.error) > 10


def test_after_all_that_it_learns_what_it_would_have_learned_anyway(bench: Bench) -> None:
    """The next model is to the bit that of a learner which saw the valid measurements alone."""
    models: queue.Queue[wire.ModelSnapshot] = bench.follow(bench.keys.model, wire.ModelSnapshot)
    teach(bench.session, bench.keys, 4, 40.0, 70.0)
    found = models.get(timeout=PATIENCE)
    node = LearnerNode(configured(), boot=bench.host.node.boot)
    expected = None
    for first, last in ((0.0, 40.0), (40.0, 70.0)):
        for name, (t, value) in leng.recording("T1", seed=4).streams().items():
            part = (t >= first) & (t < last)
            node.push(name, t[part], value[part])
        outcome = node.learn()
        expected = outcome.served if outcome is not None else expected
    assert found == expected
