"""A recording that is played faster than a learner takes it in: how much was lost is said, and a speed at which not."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest

from service.bus import ingest
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.cli.command_line import main
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.recordings.recording_csv import write
from service.wire import Keys
from simulator import leng
from simulator.intake import Intake
from tests.service.conftest import PATIENCE, configured, cut

KEYS = Keys("leng/yaw")
VALUES = 7500
"""Values of both streams in 100 s."""


@contextmanager
def learner() -> Iterator[str]:
    """One that runs, and its endpoint."""
    endpoint = free_endpoint()
    with open_session(listener_config_at(endpoint)) as session, WorkerThreads([Host(session, configured())]):
        yield endpoint


@pytest.fixture
def run(tmp_path: Path) -> Path:
    write(tmp_path / "run.csv", cut(leng.recording("T1", seed=7), 100.0))
    return tmp_path / "run.csv"


def test_what_is_lost_at_too_high_a_speed_is_said_with_a_lower_one(
    run: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ingest, "RING_PLACES", 64)
    monkeypatch.setattr(ingest, "MIN_RING_PLACES", 64)
    with learner() as endpoint:
        assert main(["replay", str(run), "--connect", endpoint, "--speed", "1e9"]) == 0
        said = capsys.readouterr().err
        found = re.search(r"the learner of leng/yaw lost ([\d,]+) of 7,500 values; .* --speed (\d+)\n", said)
        assert found is not None, said
        with open_session(client_config_at(endpoint), PATIENCE) as client:
            now = Intake(client, KEYS, threading.Event()).settled()
        assert now is not None
        lost = int(found[1].replace(",", ""))
        # A learner that wakes late on a busy machine begins to count with the first number that it sees.
        assert lost >= now.counters.get("rejected:lost", 0)
        assert lost > 0
        assert lost + sum(stream.received for stream in now.streams.values()) == VALUES
        assert 1.0 <= float(found[2]) < 1e5


def test_where_nothing_is_lost_it_says_no_more_than_that(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with learner() as endpoint:
        assert main(["replay", str(run), "--connect", endpoint, "--speed", "20"]) == 0
        assert [re.sub(r"in \d+ s", "in N s", line) for line in capsys.readouterr().err.splitlines()] == [
            "incsvr replay: played 100 s, 7,500 messages, in N s",
        ]


@pytest.mark.parametrize("bus", [True, False])
def test_without_a_learner_a_recording_and_a_simulation_say_the_same(
    run: Path, capsys: pytest.CaptureFixture[str], bus: bool
) -> None:
    endpoint = free_endpoint()
    cure = "no learner answers for leng/yaw; start `incsvr serve`" if bus else f"no bus answers at {endpoint}: start"
    with open_session(listener_config_at(endpoint)) if bus else nullcontext():
        for command in (["replay", str(run)], ["simulate", "--runs", "V2"]):
            assert main([*command, "--connect", endpoint, "--wait", "0.1"]) == 2
            assert f"incsvr {command[0]}: {cure}" in capsys.readouterr().err
