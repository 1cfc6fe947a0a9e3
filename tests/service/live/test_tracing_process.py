"""The process beside the learner: what it answers, and how it fails, hangs, dies and ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import psutil
import pytest
from numpy.lib.format import write_array_header_1_0

from incsvr.errors import BadInput
from incsvr.numerics import Streams
from service.live.tracing_job import FIRST_TO_END, MAX_MEMORY_BYTES, NICENESS, SESSION_NICENESS
from service.live.tracing_process import TracingProcess
from simulator import leng
from tests.hidden import recording
from tests.service.conftest import PATIENCE

TRACE = {"work": "trace", "inertia": leng.INERTIA, "axis": "yaw"}
StartChild = Callable[..., TracingProcess]


@pytest.fixture
def child() -> Iterator[StartChild]:
    started: list[TracingProcess] = []

    def begin(streams: Streams, job: dict[str, Any] = TRACE, **settings: float) -> TracingProcess:
        found = TracingProcess.start(job, streams, **settings)
        assert found is not None
        started.append(found)
        return found

    yield begin
    for each in started:
        each.close()
        assert not psutil.pid_exists(each.process.pid)


def ended(child: TracingProcess) -> TracingProcess:
    until = time.monotonic() + PATIENCE
    while not child.has_ended:
        assert time.monotonic() < until
        with suppress(Exception):
            child.process.wait(0.2)
    return child


def test_data_that_cannot_answer_are_one_sentence(child: StartChild) -> None:
    short = recording(1, 5.0).streams()
    with pytest.raises(BadInput, match="too few to trace anything"):
        ended(child(short)).answer()


@pytest.mark.slow
def test_a_fault_of_the_program_is_one_sentence_too(child: StartChild) -> None:
    with pytest.raises(BadInput, match=r"^KeyError: 'inertia'$"):
        ended(child(recording(1, 5.0).streams(), {"work": "trace", "axis": "yaw"})).answer()


def test_one_that_hangs_is_stopped_and_only_one_works_at_a_time(child: StartChild) -> None:
    hanging = child(recording(1, 60.0).streams(), deadline=0.5)
    os.kill(hanging.process.pid, signal.SIGSTOP)
    assert TracingProcess.start(TRACE, {}) is None
    with pytest.raises(BadInput, match=r"it was stopped after 0.5 s"):
        ended(hanging).answer()


def test_one_that_is_killed_says_by_which_signal(child: StartChild) -> None:
    killed = child(recording(1, 60.0).streams())
    killed.process.kill()
    with pytest.raises(BadInput, match="killed by signal 9"):
        ended(killed).answer()


def test_it_ends_with_the_learner_however_that_ends(child: StartChild) -> None:
    orphan = child(recording(1, 200.0).streams())
    assert isinstance(orphan.process.args, list)
    folder = Path(orphan.process.args[-1])
    assert folder.is_dir()
    assert orphan.process.stdin is not None
    orphan.process.stdin.close()  # so does the system for a process that is killed
    assert orphan.process.wait(PATIENCE) == 1
    assert not folder.exists()


def test_it_stands_back_and_is_bounded(child: StartChild) -> None:
    if not hasattr(psutil.Process, "rlimit"):
        pytest.skip("this system bounds no process")
    bounded, until = child(recording(1, 200.0).streams()), time.monotonic() + PATIENCE
    process = psutil.Process(bounded.process.pid)
    while process.rlimit(psutil.RLIMIT_AS) != (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES):  # the bound comes last
        assert time.monotonic() < until
    assert process.nice() == min(os.nice(0) + NICENESS, 19)
    proc = Path(f"/proc/{process.pid}")
    assert (proc / "oom_score_adj").read_text().strip() == FIRST_TO_END
    if (proc / "autogroup").exists() and os.geteuid() == 0:  # others may change one session in a tenth of a second
        assert (proc / "autogroup").read_text().split()[-1] == SESSION_NICENESS


def test_it_stands_back_before_it_loads_what_takes_long() -> None:
    program = "import sys, service.live.tracing_job as job; sys.exit(bool({'numpy', 'pydantic'} & {*sys.modules}))"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_one_that_needs_more_memory_than_its_bound_says_so(tmp_path: Path) -> None:
    (tmp_path / "job.json").write_text("{}")
    with ZipFile(tmp_path / "streams.npz", "w") as streams, streams.open("torque/t.npy", "w") as file:
        shape = {"descr": "<f8", "fortran_order": False, "shape": (MAX_MEMORY_BYTES // 8,)}
        write_array_header_1_0(file, shape)  # type: ignore[no-untyped-call]
    words = [sys.executable, "-m", "service.live.tracing_job", str(tmp_path)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True) as job:
        assert job.stderr is not None
        said = job.stderr.read().decode()
    assert (job.returncode, said) == (1, "it needs more than 2.1 GB of memory\n")
