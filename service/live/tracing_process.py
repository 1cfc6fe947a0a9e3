"""The process beside the learner, as the learner sees it: started, looked at now and then, never waited for.

One at a time, however many learners a process holds: tracing takes a core for seconds, and learning goes first.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.numerics import Streams
from service.config.configuration import Config
from service.config.sections import Tracing
from service.live.tracing_state import FRESH_PART, TRIAL_PART, TracingState, Work
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


class Worker(Protocol):
    """A worker beside the learner, such as `service.live.tracing_process.TracingProcess` in a process of its own."""

    @property
    def has_ended(self) -> bool: ...
    def answer(self) -> Any: ...
    def close(self) -> None: ...


Begin = Callable[[Mapping[str, Any], Streams], Worker | None]


def recent_streams(
    streams: Streams, settings: Tracing, state: TracingState, work: Work, newest: float, changed: float
) -> Streams:
    """The part of the recent streams, name → (stamps [s], values), that the work due at `newest` [s] is about.

    Args:
        changed: the time of a change of the vehicle [s]: a trace of data from before it and after takes one effect for
            another.
    """
    since = _since(settings, state, newest) if work == "prove" else max(newest - settings.window, changed)
    return {
        name: (t[(t >= since) & (t <= newest)], value[(t >= since) & (t <= newest)])
        for name, (t, value) in streams.items()
    }


def job(config: Config, state: TracingState, work: Work, newest: float, model: Model) -> dict[str, Any]:
    """The work that is due at `newest` [s], as `service.live.tracing_answer.answer` takes it; `model` is served."""
    coupled, smoothing = config.coupled(), config.signals.smoothing
    body = {} if coupled is None else {"body": coupled.to_dict(), "smoothing": smoothing}
    surface = {} if model.several is None else {"surface": model.to_dict()}
    return body | surface | _job(config, state, work, newest)


def _job(config: Config, state: TracingState, work: Work, newest: float) -> dict[str, Any]:
    if work == "trace" or state.under_test is None:
        return {
            "work": work,
            "inertia": config.vehicle.inertia,
            "axis": config.vehicle.axis,
            "rate_limit": config.vehicle.rate_limit,
            "torque": config.signals.torque,
            "half": newest - 0.5 * config.tracing.window,
            "shortest": FRESH_PART * config.tracing.window,
        }
    role, content = state.under_test
    return {
        "work": work,
        "fresh": _fresh(config.tracing, state, newest),
        "closed": content.loop != "open",
        "without": None if role == "active" or state.active is None else state.active.model,
        "effects": content.model,
    }


def _fresh(settings: Tracing, state: TracingState, newest: float) -> float:
    """The begin of the data of a proof that are unseen by its effects [s]: of suspected ones all since their trace."""
    traced = state.traced_until
    return newest - TRIAL_PART * settings.window if state.suspect is None or traced is None else traced


def _since(settings: Tracing, state: TracingState, newest: float) -> float:
    """The begin of the data of a proof [s]: no earlier than those in which its effects were found."""
    begins, under_test = _fresh(settings, state, newest) - (1.0 - TRIAL_PART) * settings.window, state.under_test
    since = None if under_test is None else under_test[1].since
    return begins if since is None else max(begins, since)
