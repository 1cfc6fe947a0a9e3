"""An operator's word on what live tracing has found: on the bus, in the ledger, through kill -9, and by `advise`."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from service import wire
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.config.configuration import Config
from service.learner.node import LearnerNode
from service.live.tracing_state import TraceContent, TracingState
from service.state.store import Store
from simulator.messages import messages
from simulator.player import play
from tests.hidden import recording, write_trace
from tests.service.commands.test_processes import KEYS, client, following, serving
from tests.service.config.test_traced_effects import part
from tests.service.conftest import PATIENCE, Bench, StartBench, configured
from tests.service.live.test_live_tracing import LIVE, Ledgers, named, until
from tests.worlds import trial

ADVISE: dict[str, Any] = {"tracing__live": "advise", "tracing__window": 240.0, "tracing__proof": 90.0}
NAMES = ("torque_lag", "bias_torque")
ERROR = {"before": {"torque_rmse": 9.0, "free_run_rmse": 0.04}, "after": {"torque_rmse": 4.0, "free_run_rmse": 0.01}}


@pytest.fixture
def found(tmp_path: Path) -> dict[str, Any]:
    """A trace of the vehicle with a hidden lag and a bent fin, as live tracing keeps it once it is proven."""
    path = tmp_path / "trace.json"
    write_trace(path)
    trace: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    findings = [{"effect": name, "sentence": f"There is a {name}.", "p_value": 1e-9, "share": 0.4} for name in NAMES]
    return trace | {"effects": findings, "since": 0.0, "until": 90.0, "proof": {"error": ERROR, "until": 180.0}}


def leave(config: Config, standing: TracingState) -> None:
    """The state that a learner leaves behind where live tracing stands so."""
    assert config.state is not None
    store = Store(config.state, config, changing=True)
    store.save_memory(LearnerNode(config, boot="").memory() | {"live": standing.to_dict()})
    store.close()


def decided(bench: Bench, verb: str, name: str) -> wire.EffectsLedger:
    payload, refusal = bench.get(f"{bench.keys.effects}/{verb}?effect={name}")
    assert payload is not None, refusal
    return wire.decode(wire.EffectsLedger, payload)


def refused(bench: Bench, selector: str) -> str:
    _, refusal = bench.get(selector)
    assert refusal is not None
    assert refusal.error_type == "BadInput"
    return refusal.error


@pytest.fixture
def bench(start: StartBench, tmp_path: Path, found: dict[str, Any]) -> Bench:
    """A learner that has learned 140 s, beside a finding that is proven and waits for an operator."""
    state = tmp_path / "state"
    leave(configured(**ADVISE, state=state), TracingState(proven=TraceContent.from_dict(found)))
    bench = start(**ADVISE, state=state)
    bench.play(part(recording(3, 400.0), 0.0, 140.0))
    bench.health_when(lambda health: health.revision >= 4)
    return bench


def test_an_operator_promotes_and_withdraws_and_the_ledger_holds_each_step_with_its_evidence(bench: Bench) -> None:
    before = bench.host.node.served.revision
    assert bench.host.node.served.effects == ()
    promoted = decided(bench, "promote", "torque_lag")
    assert named(promoted.effects) == list(NAMES)  # one trace found both: they are one model
    assert promoted.found == ()
    for step in promoted.history[-2:]:
        assert step["step"] == "promoted"
        assert step["why"].startswith("by an operator; it was proven, together with")
        assert (step["p_value"], step["error"], step["revision"]) == (1e-9, ERROR, before + 1)
        assert step["t"] > 100.0
    assert bench.host.node.served.revision == before + 1
    assert decided(bench, "promote", "torque_lag").history == promoted.history  # asked again, it changes nothing
    withdrawn = decided(bench, "withdraw", "bias_torque")
    assert withdrawn.effects == ()
    assert [step["step"] for step in withdrawn.history[-2:]] == ["withdrawn", "withdrawn"]
    assert withdrawn.history[-1]["revision"] == bench.host.node.served.revision == before + 2
    assert decided(bench, "withdraw", "torque_lag").history == withdrawn.history


def test_a_wrong_name_or_way_gets_a_sentence_that_names_the_right_one(bench: Bench) -> None:
    promote, withdraw = f"{bench.keys.effects}/promote", f"{bench.keys.effects}/withdraw"
    known = "found: torque_lag, bias_torque; in force: nothing"
    assert refused(bench, f"{promote}?effect=torque_lug") == f"torque_lug was not found here; {known}"
    assert "is not in force here, so it cannot be withdrawn" in refused(bench, f"{withdraw}?effect=torque_lag")
    assert "such as ?effect=torque_lag" in refused(bench, promote)
    assert "is no parameter of" in refused(bench, f"{promote}?name=torque_lag")
    assert bench.host.node.ledger.history == ()


def test_where_nothing_is_traced_there_is_nothing_to_promote(start: StartBench) -> None:
    bench = start()
    assert "set it to advise or adopt" in refused(bench, f"{bench.keys.effects}/promote?effect=torque_lag")


@pytest.mark.slow
def test_what_was_decided_survives_kill_9_at_once(
    tmp_path: Path, found: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    endpoint, state = free_endpoint(), tmp_path / "state"
    words = [f"{name.replace('__', '.')}={value}" for name, value in ADVISE.items()]
    flags = [word for each in words for word in ("--set", each)]
    leave(configured(**ADVISE, state=state), TracingState(proven=TraceContent.from_dict(found)))
    with serving(endpoint, state, *flags) as learner, client(endpoint) as (session, alive):
        assert "PUT" in alive.get(timeout=PATIENCE)
        models = following(session)
        play(session, KEYS, messages(part(recording(3, 400.0), 0.0, 140.0).streams()), speed=500.0, stop=Event())
        while models.get(timeout=PATIENCE).revision < 4:
            pass
        assert main(["effects", "promote", "torque_lag", "--connect", endpoint, "--json", "-"]) == 0
        learner.send_signal(signal.SIGKILL)
        said = json.loads(capsys.readouterr().out)
        assert learner.wait(PATIENCE) == -signal.SIGKILL
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, state, *flags):
            assert "PUT" in alive.get(timeout=PATIENCE)
            assert main(["effects", "--connect", endpoint, "--json", "-"]) == 0
            again = json.loads(capsys.readouterr().out)
    assert [finding["effect"] for finding in said["effects"]] == list(NAMES)
    assert again == said


@pytest.mark.slow
def test_advise_says_what_is_proven_and_serves_the_same_bytes_as_without(start: StartBench) -> None:
    lagging = trial(1, ("torque_lag",), duration=700.0).recording
    bench = start(**LIVE | {"tracing__live": "advise"})
    ledgers: Ledgers = bench.follow(bench.keys.effects, wire.EffectsLedger)
    bench.play(part(lagging, 0.0, 280.0))
    suspected = until(ledgers, "suspected")
    assert [finding["state"] for finding in suspected.found] == ["suspected"]
    bench.play(part(lagging, 280.0, 400.0))
    proven = until(ledgers, "proven")
    (finding,) = proven.found
    assert (finding["effect"], finding["state"]) == ("torque_lag", "proven")
    assert finding["error"]["after"]["free_run_rmse"] < finding["error"]["before"]["free_run_rmse"]
    assert finding["error"]["after"]["torque_rmse"] < finding["error"]["before"]["torque_rmse"]
    assert proven.history[-1]["error"] == finding["error"]
    assert proven.effects == ()
    off = LearnerNode(configured(**LIVE | {"tracing__live": "off"}), boot=bench.host.node.boot)
    for name, (t, value) in lagging.streams().items():
        off.push(name, t, value)
    served = bench.host.node.latest()
    assert served is not None
    while (without := off.latest()) is None or without.revision < served.revision:
        assert off.learn() is not None
    assert wire.encode(served) == wire.encode(without)
