"""What a terminal shows of a running learner: `incsvr status`, also with `--follow`, and the log of `incsvr serve`."""

from __future__ import annotations

import json
import queue
import re
import signal
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

import pytest

from service import wire
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.cli.output import WIDTH
from service.commands.status import text
from tests.service.commands.test_processes import KEYS, client_after, command, endpoint, following, next_model
from tests.service.conftest import PATIENCE, teach

__all__ = ["endpoint"]

STARVED = "torque waits for yaw rate, whose stamps are 3600.0 s behind (12.3 s and 3612.3 s); stamp both with one clock"


@pytest.fixture
def health() -> wire.Health:
    """A health with everything in it that a screen must find room for."""
    return wire.Health(
        level="WARN",
        reasons=(f"learning is starved: {STARVED}", "12345 values rejected: clock jump"),
        counters={"samples": 1234567, "iterations": 24691, "rejected": 12345, "rejected:clock_jump": 12345},
        learned=0.95,
        boot="b",
        revision=24691,
        iteration=24691,
        uptime_s=400_000.0,
        streams={
            "yaw_rate": wire.StreamHealth(
                received=123456789, lost=1234, age_s=0.02, t=1764040000.0, value=-0.0834, period_s=0.02, held=200_000
            ),
            "torque": wire.StreamHealth(),
            "thruster_1_speed_measured": wire.StreamHealth(received=5, age_s=12.0, t=3.0, value=141.4, held=5),
        },
        learning=wire.Learning(state="starved", since=8.1, why=STARVED),
    )


def test_the_screen_fits_and_says_what_is_wrong(health: wire.Health) -> None:
    model = wire.ModelSnapshot(
        boot="b",
        revision=24691,
        iteration=24691,
        t=1764040000.0,
        kernel=wire.Kernel(gamma=10.0),
        epsilon=0.1,
        C=1000.0,
        support=wire.Support(rate=(-0.2, 0.2), damping=(-80.0, 80.0), weight=(-90.0, 90.0)),
        inertia=350.0,
        effects=({"effect": "torque_lag"},),
        noise=3.9,
        trained_range=(-0.2, 0.2),
    )
    shown = text("vehicle/with/a/long/prefix/yaw", health, model)
    assert max(map(len, shown.splitlines())) <= WIDTH
    together = " ".join(re.sub(r"[!\n]", " ", shown).split())
    for words in (
        "WARN",
        "starved since 8.1 s",
        STARVED,
        "12345 clock jump",
        " 50 0.0 1764040000.0 ",
        "-0.0834 rad/s",
        "torque_lag",
    ):
        assert words in together
    assert "none yet" in text("leng/yaw", health, None)


def asked(endpoint: str, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    status = main(["status", "--connect", endpoint, *words])
    told = capsys.readouterr()
    return status, told.out, told.err


def test_status_is_one_where_nobody_answers(endpoint: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, error = asked(endpoint, capsys, "--wait", "0")
    assert (status, out) == (1, "")
    assert error.startswith(f"incsvr status: no bus answers at {endpoint}: start `incsvr serve`")
    assert main(["status", "--follow", "--connect", free_endpoint(), "--wait", "0"]) == 1


@pytest.mark.slow
def test_status_tells_of_a_real_learner_and_follows_it(
    endpoint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    watch = subprocess.Popen(
        command("watch", "--connect", endpoint), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert watch.stderr is not None
    assert watch.stderr.readline().startswith("incsvr watch: use `incsvr status --follow`; ")
    assert "waiting for the bus: " in watch.stderr.readline()
    with client_after(endpoint, tmp_path) as (process, session, _):
        status, out, error = asked(endpoint, capsys, "--json", "-")
        found = json.loads(out)
        assert status == (0 if found["health"]["level"] == "OK" else 1)
        assert found["model"] is None
        assert "the first follows the first batch" in error

        lines: queue.Queue[str] = queue.Queue()
        assert watch.stdout is not None
        reader = threading.Thread(target=lambda out: deque(map(lines.put, out)), args=(watch.stdout,))
        reader.start()
        try:
            while "health is" not in lines.get(timeout=PATIENCE):
                pass
            models = following(session)
            teach(session, KEYS, 9, 0, 35)
            model = next_model(models)
            while not (line := lines.get(timeout=PATIENCE)).startswith("iteration 1, "):
                pass
            assert f"{len(model.support)} vectors" in line
            capsys.readouterr()
            assert main(["query", "5", "--connect", endpoint]) == 0
            first = capsys.readouterr().out.splitlines()[0]
            assert model.trained_range is not None
            assert first == f"not learned there (up to {model.trained_range[1]:.3g} rad/s)"
            watch.send_signal(signal.SIGINT)
            assert watch.wait(PATIENCE) == 0
        finally:
            watch.kill()
            watch.wait()
            reader.join()
            watch.stdout.close()
            watch.stderr.close()

        until = time.monotonic() + PATIENCE
        while (seen := asked(endpoint, capsys))[0] == 0:  # until the streams are silent for too long
            assert time.monotonic() < until
        assert "STALE" in seen[1]
        assert "revision 1, iteration 1" in seen[1]

        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert process.stderr is not None
        told = process.stderr.read().decode()
    for words in (
        f"listens at {endpoint}",
        "receives leng/yaw/rate, leng/yaw/torque and leng/yaw/channel/*",
        f"keeps its state in {tmp_path}/leng/yaw.sqlite",
        "leng/yaw: iteration 1, ",
    ):
        assert words in told
