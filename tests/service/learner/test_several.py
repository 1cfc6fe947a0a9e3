"""A learner over several velocities on the bus: its configuration, streams, snapshots, answers, and its state."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.config.sources import read
from service.recordings.recording import Recording, from_table
from service.wire import DampingReply
from tests import worlds
from tests.planar import planar
from tests.service.commands.test_processes import KEYS, client_after, command, endpoint, following, next_model, serving
from tests.service.conftest import PATIENCE, StartBench

__all__ = ["endpoint"]

SEED = 910108
INPUTS = ("yaw_rate", "surge", "sway")


@pytest.fixture(scope="module")
def run() -> Recording:
    return worlds.planar(SEED, 140.0)


def told(seed: int = SEED) -> dict[str, object]:
    """What the configuration has to say of the simulated vehicle."""
    return {"vehicle__inertia": planar(seed).inertia, "learner__inputs": INPUTS}


def send(session: zenoh.Session, recording: Recording, first: float, last: float) -> None:
    """Part of a recording, in messages that carry five seconds of a stream; nothing is dropped."""
    for start in np.arange(first, last, 5.0).tolist():
        for name, (t, value) in recording.streams().items():
            part = (t >= start) & (t < min(start + 5.0, last))
            payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
            session.put(KEYS.stream(name), payload, congestion_control=zenoh.CongestionControl.BLOCK)


def asked(session: zenoh.Session, selector: str) -> DampingReply:
    (reply,) = list(session.get(selector, timeout=PATIENCE))
    assert reply.ok is not None, reply.err and reply.err.payload.to_string()
    return wire.decode(DampingReply, reply.ok.payload.to_bytes())


@pytest.mark.slow
def test_a_process_learns_over_three_answers_for_two_and_comes_back_after_kill_9(
    endpoint: str, tmp_path: Path, run: Recording
) -> None:
    words = [f"--set={name.replace('__', '.')}={json.dumps(value)}" for name, value in told().items()]
    question = f"{KEYS.damping}?yaw_rate=0.1,-0.1;surge=0.4;sway=0.05,-0.05"
    with client_after(endpoint, tmp_path, *words) as (process, session, alive):
        models = following(session)
        send(session, run, 0.0, 140.0)
        for _ in range(4):
            snapshot = next_model(models)
        over = snapshot.to_dict()["over"]
        assert over["inputs"] == list(INPUTS)
        assert set(snapshot.support.others) == set(over["trained_ranges"]) == {"surge", "sway"}
        answer = asked(session, question)
        points = np.array([[0.1, 0.4, 0.05], [-0.1, 0.4, -0.05]])
        expected = snapshot.model.over(points)
        assert answer.damping == tuple(expected.damping)
        # The learner's BLAS has one thread and this process's two: a triangular solution is rounded otherwise.
        assert answer.sigma == pytest.approx(tuple(expected.sigma), rel=1e-12)
        assert answer.others == {"surge": (0.4, 0.4), "sway": (0.05, -0.05)}
        cli = subprocess.run(
            command("query", "0.1", "surge=0.4", "sway=0.05", "--connect", endpoint, "--json", "-"),
            capture_output=True, check=True, timeout=PATIENCE,
        )  # fmt: skip
        assert json.loads(cli.stdout)["damping"] == pytest.approx([answer.damping[0]], rel=1e-12)
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE)
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path, *words):
            assert "PUT" in alive.get(timeout=PATIENCE)
            assert asked(session, question) == answer
            then = asked(session, f"{KEYS.damping}?rate=0.1;surge=0.4;sway=0.05;revision=2")
            assert then.revision == 2


def test_questions_over_several_velocities(start: StartBench, run: Recording) -> None:
    bench = start(**told())
    models: queue.Queue[wire.ModelSnapshot] = bench.follow(bench.keys.model, wire.ModelSnapshot)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    bench.play(run)
    report, snapshot = reports.get(timeout=PATIENCE), models.get(timeout=PATIENCE)
    for name in ("surge", "sway"):
        assert len(report.support.others[name]) == len(report.support)
        assert len(report.batch.channels[name]) == 50
    assert len(snapshot.support) == report.counts["support"]
    usual = asked(bench.session, f"{bench.keys.damping}?rate=0.1")
    assert set(usual.others) == {"surge", "sway"}  # where nobody names them the answer says at which they are
    same = f"surge={usual.others['surge'][0]!r};revision={usual.revision}"  # it may have learned on since
    some = asked(bench.session, f"{bench.keys.damping}?rate=0.1;{same}")
    assert some.damping == usual.damping
    payload, _ = bench.get(bench.keys.damping, b'{"rate": [0.1, 0.2], "others": {"surge": [0.5]}}')
    assert payload is not None
    assert wire.decode(DampingReply, payload).others["surge"] == (0.5, 0.5)
    for question, what in (
        ("surge=0.5", "give the own velocity as well"),
        ("rate=0.1;heave=0.2", "ask with rate, yaw_rate, surge, sway"),
        ("rate=0.1,0.2;surge=1,2,3", "the same number of values"),
        ("rate=0.1&surge=0.5", "separate velocities by ;"),
        ("rate=0.1;surge=fast", "surge=fast is no list of numbers"),
        ("rate=0.1;surge=nan", "a value of surge is NaN"),
        ("rate=0.1;yaw_rate=0.2", "under two names"),
    ):
        _, error = bench.get(f"{bench.keys.damping}?{question}")
        assert error is not None, question
        assert error.error_type == "BadInput"
        assert what in error.error
    _, error = bench.get(bench.keys.damping, b'{"rate": [0.1], "others": {"heave": [0.5]}}')
    assert error is not None
    assert "damping is learned over yaw_rate, surge, sway" in error.error
    payload, _ = bench.get(bench.keys.forecast, b'{"t": [0, 5], "torque": [0, 0]}')
    assert payload is not None
    forecast = wire.decode(wire.ForecastReply, payload)
    assert forecast.rate[0] == forecast.measured
    assert forecast.rate_low[1] < forecast.rate[1] < forecast.rate_high[1]


def test_samples_wait_for_the_further_velocities_and_what_lacks_one_is_counted(
    start: StartBench, run: Recording
) -> None:
    bench = start(**told())
    columns = {name: values for name, values in run.columns.items() if name != "sway"}
    bench.play(from_table(run.name, run.time, columns))
    health = bench.health_when(lambda said: said.counters.get("rejected:no_sway", 0) > 50)
    assert health.counters["iterations"] == 0


@pytest.mark.parametrize(
    ("learner", "what"),
    [
        ({"inputs": ["surge", "yaw_rate"]}, "begins with the axis's own velocity, yaw_rate"),
        ({"inputs": ["yaw_rate", "surge", "surge"]}, "twice"),
        ({"inputs": ["yaw_rate", "depth"]}, "depth is no velocity"),
        ({"inputs": ["yaw_rate", "surge"], "solver": "passes"}, "the passes of Eq. 8 are for one velocity"),
        ({"inputs": ["yaw_rate", "surge"], "fastest": {"sway": 1.0}}, "fastest names sway"),
        ({"fastest": {"surge": 1.0}}, "no further input"),
        ({"inputs": ["yaw_rate", "surge"], "fastest": {"surge": -1.0}}, "greater than 0"),
        ({"inputs": ["yaw_rate", "surge"], "policy": "paper"}, "take weighted"),
        ({"inputs": ["yaw_rate", "surge"], "near": {"surge": 1.0}}, "learner.near left the configuration"),
    ],
)
def test_a_wrong_configuration_is_told(learner: dict[str, object], what: str) -> None:
    with pytest.raises(BadInput, match=what):
        read(None, {"learner": learner})
