"""Live tracing on the bus: a vehicle whose rotors lag is played; what its model lacks is found, proven and taken up."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from incsvr.errors import BadInput
from service import wire
from service.bus.session import free_endpoint
from service.config.traced_effects import configured_effects as effects_of
from service.learner.node import LearnerNode
from service.recordings.recording import Recording
from simulator import player
from simulator.messages import messages
from tests.hidden import recording, write_trace
from tests.service.commands.test_processes import KEYS, client, serving
from tests.service.config.test_traced_effects import ledger, part
from tests.service.conftest import PATIENCE, Bench, StartBench, configured
from tests.worlds import trial

INERTIA = 350.0
LIVE: dict[str, Any] = {
    "vehicle__inertia": INERTIA,
    "vehicle__rate_range": [-0.35, 0.35],
    "tracing__live": True,
    "tracing__window": 240.0,
    "tracing__proof": 90.0,
}
ENOUGH = 160.0
"""More than half a window and a batch [s]: then what is in force is compared again."""
TRACED_S = 8.0 * PATIENCE
"""How long a test waits for a trace [s]: its process comes after all other work of the machine."""
Ledgers = queue.Queue[wire.EffectsLedger]


@pytest.fixture(scope="module")
def lagging() -> Recording:
    return trial(1, ("torque_lag",), duration=700.0).recording


@pytest.fixture(scope="module")
def mended() -> Recording:
    """The same vehicle and noise, without the lag."""
    return trial(1, duration=1500.0).recording


def until(ledgers: Ledgers, step: str) -> wire.EffectsLedger:
    """The first ledger whose last step is this."""
    while True:
        said = ledgers.get(timeout=TRACED_S)
        if said.history and said.history[-1]["step"] == step:
            return said


def begun(ledgers: Ledgers) -> None:
    """Returns once a trace has begun."""
    while ledgers.get(timeout=TRACED_S).work != "trace":
        pass


def named(effects: tuple[dict[str, Any], ...]) -> list[str]:
    return [str(effect["effect"]) for effect in effects]


def tracing() -> list[psutil.Process]:
    """The processes beside the learners of this one."""
    return [each for each in psutil.Process().children() if "service.live.tracing_job" in each.cmdline()]


def latest(bench: Bench) -> wire.ModelSnapshot:
    payload, _ = bench.get(bench.keys.model)
    assert payload is not None
    return wire.decode(wire.ModelSnapshot, payload)


@pytest.mark.slow
def test_a_hidden_lag_is_found_proven_taken_up_kept_over_a_restart_and_withdrawn_when_it_is_mended(
    start: StartBench, lagging: Recording, mended: Recording, tmp_path: Path
) -> None:
    first = start(**LIVE, state=tmp_path)
    ledgers = first.follow(first.keys.effects, wire.EffectsLedger)
    models = first.follow(first.keys.model, wire.ModelSnapshot)
    first.play(part(lagging, 0.0, 280.0))
    shadow = until(ledgers, "suspected")
    assert shadow.effects == ()
    assert latest(first).effects == ()
    first.play(part(lagging, 280.0, 400.0))
    promoted = until(ledgers, "promoted")
    assert named(promoted.effects) == ["torque_lag"]
    assert [step["step"] for step in promoted.history] == ["suspected", "promoted"]
    assert promoted.history[-1]["why"].startswith("on data after the trace the error of the free run is lower: torque ")
    snapshot = latest(first)
    assert named(snapshot.effects) == ["torque_lag"]
    published = [models.get(timeout=PATIENCE) for _ in range(snapshot.revision)]
    assert [each.revision for each in published] == list(range(1, snapshot.revision + 1))
    assert [each.iteration for each in published] == [each.revision for each in published]
    assert "torque_lag" in latest_report(first).batch.parts
    first.stop()

    second = start(**LIVE, state=tmp_path)
    assert not [reason for reason in second.health().reasons if "set aside" in reason]
    again = latest(second)
    assert replace(again, boot="") == replace(snapshot, boot="")
    assert ledger(second).history == promoted.history
    ledgers = second.follow(second.keys.effects, wire.EffectsLedger)
    end = 700.0
    second.play(part(mended, 400.0, end))
    # How far the data of a proof reach depends on the machine's load: where one could not tell, there are further data.
    while (withdrawn := ledgers.get(timeout=TRACED_S)).history[-1]["step"] != "withdrawn":
        if withdrawn.work is None:
            second.play(part(mended, end, end + ENOUGH))
            end += ENOUGH
    assert withdrawn.effects == ()
    assert latest(second).effects == ()
    assert latest_report(second).batch.parts == {}
    second.stop()

    off = start(**LIVE | {"tracing__live": False}, state=tmp_path)
    assert off.health().revision == latest(off).revision > snapshot.revision


def latest_report(bench: Bench) -> wire.IterationReport:
    payload, _ = bench.get(bench.keys.iteration)
    assert payload is not None
    return wire.decode(wire.IterationReport, payload)


def test_a_process_that_dies_is_a_line_in_the_ledger_and_learning_goes_on(
    start: StartBench, lagging: Recording
) -> None:
    bench = start(**LIVE)
    ledgers = bench.follow(bench.keys.effects, wire.EffectsLedger)
    bench.play(part(lagging, 0.0, 280.0))
    begun(ledgers)
    (child,) = tracing()
    os.kill(child.pid, signal.SIGKILL)
    failed = until(ledgers, "failed")
    assert failed.history[-1]["why"] == "the trace failed: its process was killed by signal 9"
    before = latest(bench).revision
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(part(lagging, 280.0, 345.0))
    begun(ledgers)  # on fresh data it is tried again
    assert models.get(timeout=PATIENCE).revision > before
    assert bench.health_when(lambda health: health.counters["iterations"] > before)


def test_a_learner_that_ends_takes_its_process_with_it(start: StartBench, lagging: Recording) -> None:
    bench = start(**LIVE)
    ledgers = bench.follow(bench.keys.effects, wire.EffectsLedger)
    bench.play(part(lagging, 0.0, 280.0))
    begun(ledgers)
    assert tracing()
    bench.stop()
    assert not tracing()


def test_taught_again_it_is_the_learner_that_had_the_effects_from_the_beginning(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.json")
    with_effects = configured(effects=tmp_path / "trace.json")
    effects = effects_of(with_effects)
    whole = LearnerNode(with_effects, boot="", effects=effects)
    taught = LearnerNode(configured(tracing__live=True), boot="")
    outcomes = []
    for name, (t, value) in recording(3, 200.0).streams().items():
        whole.push(name, t, value)
        taught.push(name, t, value)
    while (outcome := whole.learn()) is not None:
        outcomes.append(outcome)
    while taught.learn() is not None:
        pass
    before = taught.served
    after = taught.relearn(effects, {})
    assert after is not None
    assert (after.served.revision, after.served.iteration) == (before.revision + 1, before.iteration + 1)
    assert after.served.support == outcomes[-1].served.support
    assert after.report.batch == outcomes[-1].report.batch
    assert taught.batches.to_dict() == whole.batches.to_dict()


@pytest.mark.slow
def test_a_learner_that_is_killed_takes_its_process_with_it(tmp_path: Path, lagging: Recording) -> None:
    endpoint = free_endpoint()
    words = [f"{name.replace('__', '.')}={value}" for name, value in LIVE.items()]
    flags = [word for each in words for word in ("--set", each)]
    with serving(endpoint, tmp_path, *flags) as learner, client(endpoint) as (session, alive):
        assert "PUT" in alive.get(timeout=PATIENCE)
        ledgers: Ledgers = queue.Queue()
        session.declare_subscriber(
            KEYS.effects, lambda sample: ledgers.put(wire.decode(wire.EffectsLedger, sample.payload.to_bytes()))
        )
        streamed = messages(part(lagging, 0.0, 280.0).streams())
        player.play(session, KEYS, streamed, speed=200.0, stop=threading.Event())
        begun(ledgers)
        children = psutil.Process(learner.pid).children()
        assert len(children) == 1
        learner.send_signal(signal.SIGKILL)
        _, left = psutil.wait_procs(children, timeout=PATIENCE)
        assert not left


def test_where_it_is_off_nothing_of_it_is_loaded_or_kept() -> None:
    program = (
        "import sys, service.commands.serve; "
        "sys.exit(bool({'service.live.live_tracing', 'service.live.tracing_process', 'scipy.stats'} & {*sys.modules}))"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
    node = LearnerNode(configured(), boot="")
    node.push("yaw_rate", np.arange(50, dtype=np.float64), np.zeros(50))
    assert node.batches.recent() == {}
    assert node.batches.window_end() is None


def test_until_something_is_promoted_it_publishes_the_same_bytes_as_without() -> None:
    nodes = [LearnerNode(configured(tracing__live=live), boot="") for live in (False, True)]
    for name, (t, value) in recording(3, 100.0).streams().items():
        for node in nodes:
            node.push(name, t, value)
    for _ in range(3):
        off, live = (node.learn() for node in nodes)
        assert off is not None
        assert live is not None
        assert wire.encode(off.served) == wire.encode(live.served)
        assert off.report.batch == live.report.batch
    assert nodes[0].memory() == nodes[1].memory()


def test_without_enough_recent_data_nothing_changes() -> None:
    node = LearnerNode(configured(tracing__live=True), boot="")
    with pytest.raises(BadInput, match="fill no batch"):
        node.relearn(None, {})
    assert node.latest() is None
