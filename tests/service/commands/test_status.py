"""What a terminal shows of a running learner: `incsvr status`, also with `--follow`, and the log of `incsvr serve`."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

import pytest

from service.bus.session import free_endpoint
from service.cli.command_line import main
from tests.service.commands.test_processes import KEYS, client_after, command, endpoint, following, next_model
from tests.service.conftest import PATIENCE, teach

__all__ = ["endpoint"]


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
            assert model.model.trained_range is not None
            assert first == f"not learned there (up to {model.model.trained_range[1]:.3g} rad/s)"
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
