"""The identification that a browser asked for: one log at a time, in a process that stands back behind the learner."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any, Protocol

JOB = "service.commands.identify_job"
"""The program of the process; named and not imported, for this one holds no more than it needs."""
MAX_LOG_BYTES = 256 * 1024**2
"""Largest log that is taken: an hour of a busy vehicle takes half of it."""
MAX_RECEIVING_S = 900.0
"""A log has come within so long [s], or is given up: 256 MB at 0.3 MB/s."""
MIN_FREE_BYTES = 128 * 1024**2
"""Room on the disk that a log must leave."""
MAX_COLUMNS, MAX_COLUMN_CHARS = 24, 200
"""Columns that a browser may name, and how long each may be."""
RESULTS = {"report.html": "text/html; charset=utf-8", "vehicle.yaml": "application/yaml"}
"""What may be fetched once it has ended well."""
_MAX_REASON_CHARS = 600
_PIECE_BYTES = 1 << 20
_ODD = re.compile(r"[^A-Za-z0-9_.-]+")


class Refused(Exception):
    """A log that is not taken, with the reason as text."""


class Source(Protocol):
    """Where a log comes from: a browser's request, or a file."""

    def read(self, size: int, /) -> bytes: ...


class Identification:
    """At most one process; its methods may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: TemporaryDirectory[str] | None = None
        self._name = ""
        self._receiving = False
        self._stopped = False
        self._began = 0.0

    def start(self, name: str, source: Source, size: int, columns: Sequence[str] = ()) -> None:
        """Takes a log of so many bytes, and begins to identify its vehicle.

        Args:
            name: of the log, as people call it.
            columns: as of `incsvr identify --column`.

        Raises:
            Refused: one is at work, or the log is empty, too large, or broke off.
        """
        if size <= 0:
            raise Refused("the log is empty; choose another file")
        if size > MAX_LOG_BYTES:
            raise Refused(f"a log of {size / 1e6:.0f} MB is too large; the largest is {MAX_LOG_BYTES / 1e6:.0f} MB")
        if len(columns) > MAX_COLUMNS or any(len(each) > MAX_COLUMN_CHARS for each in columns):
            raise Refused("too many columns are named; name those of the velocities and the efforts alone")
        with self._lock:
            if self._receiving or self._is_running():
                raise Refused(f"{self._name} is being identified; wait for its end, or stop it")
            self._close()
            self._receiving, self._name = True, _ODD.sub("_", Path(name).name)[-80:].lstrip("-.") or "log"
            self._folder = TemporaryDirectory(prefix="incsvr-page-", ignore_cleanup_errors=True)
            folder = Path(self._folder.name)
        try:
            if shutil.disk_usage(folder).free < size + MIN_FREE_BYTES:
                raise Refused("the vehicle has no room for this log; remove recordings, or cut it with incsvr convert")
            with (folder / self._name).open("wb") as file:
                _copy(source, file, size)
            with self._lock:
                self._run(folder, columns)
        except BaseException:
            with self._lock:
                self._close()
            raise
        finally:
            with self._lock:
                self._receiving = False

    def stop(self) -> None:
        """Ends the process, if there is one."""
        with self._lock:
            if self._is_running():
                self._stopped = True
                self._end()

    def close(self) -> None:
        """Ends the process and removes what it wrote."""
        with self._lock:
            self._close()

    def state(self) -> dict[str, Any]:
        """What a browser shows: `state` is none, receiving, running, done or failed."""
        with self._lock:
            found = {"name": self._name, "largest_bytes": MAX_LOG_BYTES}
            if self._receiving:
                return found | {"state": "receiving"}
            if self._process is None:
                return found | {"state": "none"}
            status = self._process.poll()
            if status is None:
                seconds = round(time.monotonic() - self._began)
                return found | {"state": "running", "seconds": seconds, **self._json("progress.json")}
            if status == 0:
                return found | {"state": "done", **_summary(self._json("result.json"))}
            return found | {"state": "failed", "why": self._reason(status)}

    def result(self, name: str) -> bytes | None:
        """The report or the vehicle file; None where there is none."""
        with self._lock:
            if name not in RESULTS or self._process is None or self._process.poll() != 0 or self._folder is None:
                return None
            try:
                return (Path(self._folder.name) / name).read_bytes()
            except OSError:
                return None

    @property
    def vehicle(self) -> str:
        """What the vehicle of the log is called: as its file."""
        return _ODD.sub("_", Path(self._name).stem) or "vehicle"

    def _run(self, folder: Path, columns: Sequence[str]) -> None:
        words = ["--name", self.vehicle, *(f"--column={each}" for each in columns), "--", str(folder / self._name)]
        with (folder / "said").open("wb") as said:
            self._process = subprocess.Popen(
                [sys.executable, "-m", JOB, str(folder), *words],
                stdin=subprocess.PIPE,
                stdout=said,
                stderr=said,
                start_new_session=True,
                env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"},
            )
        self._began, self._stopped = time.monotonic(), False

    def _is_running(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def _end(self) -> None:
        if self._process is None:
            return
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            self._process.stdin.close()

    def _close(self) -> None:
        self._end()
        self._process = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def _json(self, name: str) -> dict[str, Any]:
        assert self._folder is not None
        try:
            return dict(json.loads((Path(self._folder.name) / name).read_text(encoding="utf-8")))
        except (OSError, ValueError):
            return {}

    def _reason(self, status: int) -> str:
        """Why it gave no answer, in one sentence."""
        if self._stopped:
            return "it was stopped"
        if status == -signal.SIGXCPU:
            return "it took too much processor time; cut the log with incsvr convert"
        if status < 0:
            return f"its process was ended by signal {-status}: the machine may lack memory"
        assert self._folder is not None
        said = (Path(self._folder.name) / "said").read_text(encoding="utf-8", errors="replace").strip()
        last = (said.splitlines() or [f"its process ended with status {status}"])[-1]
        return last.replace(f"{self._folder.name}{os.sep}", "").removeprefix("incsvr identify: ")[:_MAX_REASON_CHARS]


def _copy(source: Source, file: IO[bytes], size: int) -> None:
    """Copies so many bytes.

    Raises:
        Refused: they do not come, or too slowly.
    """
    until, left = time.monotonic() + MAX_RECEIVING_S, size
    while left > 0:
        piece = source.read(min(left, _PIECE_BYTES))
        if not piece or time.monotonic() > until:
            raise Refused("the upload of the log broke off; send it again")
        file.write(piece)
        left -= len(piece)


def _summary(found: dict[str, Any]) -> dict[str, Any]:
    """Of the result what fits beside its report: errors 5 s ahead by axis, what is not identified, why no report."""
    free_run = found["free_run"]
    ahead = free_run["horizons"].get("5", {})
    errors = [{"axis": axis, "model": each["model"], "held": each["hold"]} for axis, each in ahead.items()]
    refusals = [f"{axis}: {each['reason']}" for axis, each in found["axes"].items() if not each["identified"]]
    missing = [*refusals, *found["warnings"], *found["manoeuvres"]]
    return {"errors": errors, "on": free_run["on"], "missing": missing, "no_report": found["no_report"]}
