"""The process beside the learner, as the learner sees it: started, looked at now and then, never waited for.

One at a time, however many learners a process holds: tracing takes a core for seconds, and learning goes first.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Streams
from service.live.tracing_job import MAX_PROCESSOR_S
from service.wire.json_text import write_json

DEADLINE_S = 600.0
"""The time after which a process hangs [s], by the clock on the wall: the slowest trace known took 24."""
_MAX_REASON_CHARS = 300
_work_lock = threading.Lock()


class TracingProcess:
    """One piece of work (see `service.live.tracing_job`) in a process of its own, until `close`."""

    def __init__(self, job: Mapping[str, Any], streams: Streams, deadline: float) -> None:
        self._folder = TemporaryDirectory(prefix="incsvr-", ignore_cleanup_errors=True)
        self._until, self._deadline = time.monotonic() + deadline, deadline
        folder = Path(self._folder.name)
        try:
            _save(folder, job, streams)
            with (folder / "said").open("wb") as said:
                self.process = subprocess.Popen(
                    [sys.executable, "-m", "service.live.tracing_job", str(folder)],
                    stdin=subprocess.PIPE,
                    stdout=said,
                    stderr=said,
                    start_new_session=True,  # Ctrl-C is for the learner, which ends it
                    # Threads of BLAS that wait for one another would take the learner's core as well.
                    env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
                )
        except BaseException:
            self._folder.cleanup()
            raise

    @staticmethod
    def start(job: Mapping[str, Any], streams: Streams, deadline: float = DEADLINE_S) -> TracingProcess | None:
        """Begins the work; None where a process works already.

        Raises:
            OSError: the machine gives no process, or no room for its data.
        """
        if not _work_lock.acquire(blocking=False):
            return None
        try:
            return TracingProcess(job, streams, deadline)
        except BaseException:
            _work_lock.release()
            raise

    @property
    def has_ended(self) -> bool:
        """Whether there is an answer, or there will be none."""
        return self.process.poll() is not None or time.monotonic() > self._until

    def answer(self) -> Any:
        """The result of the process, once it has ended.

        Raises:
            BadInput: it was killed, hung or failed, or the data cannot answer, in one sentence.
        """
        folder, status = Path(self._folder.name), self.process.poll()
        if status is None:
            raise BadInput(f"it was stopped after {self._deadline:g} s")
        if status < 0 and status == -signal.SIGXCPU:
            raise BadInput(f"it took more than {MAX_PROCESSOR_S} s of processor time")
        if status < 0:
            raise BadInput(f"its process was killed by signal {-status}")
        if status > 0:
            said = (folder / "said").read_text(encoding="utf-8", errors="replace").strip()
            raise BadInput((said.splitlines() or [f"its process ended with status {status}"])[-1][:_MAX_REASON_CHARS])
        try:
            return json.loads((folder / "answer.json").read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise BadInput(f"its answer cannot be read: {error}") from None

    def close(self) -> None:
        """Ends the process where it has not ended, and removes its data."""
        self.process.kill()
        self.process.wait()
        if self.process.stdin is not None:
            self.process.stdin.close()
        self._folder.cleanup()
        _work_lock.release()


def _save(folder: Path, job: Mapping[str, Any], streams: Streams) -> None:
    write_json(folder / "job.json", job)
    stamps = {f"{name}/t": t for name, (t, _) in streams.items()}
    values = {f"{name}/v": value for name, (_, value) in streams.items()}
    np.savez(folder / "streams.npz", allow_pickle=False, **stamps, **values)
