"""A long run recorded: time for one iteration, size on disk, how long the viewer takes to open it.

The real learner learns from Leng's T1 played over and over, one iteration every five seconds of the vehicle's time, and
the viewer's own pages record it: yaw rate at 50 Hz, torque at 25 Hz, health once in five seconds.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.study import begin, options
from benchmarks.study import write as write_result
from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.config.sources import read
from service.learner.node import LearnerNode
from service.wire import Health, Measurement
from simulator.leng import recording
from viewer import archive
from viewer.compare import Choice
from viewer.frame import Frame
from viewer.pages import blueprint
from viewer.palette import DARK
from viewer.recorder import Recorder
from viewer.recording_pages import RecordingPages
from viewer.screen import Screen

ITERATION_PERIOD_S = 5.0  # s of the vehicle's time for an iteration
BATCH_SAMPLES = 50


def measure(path: Path, hours: float) -> dict[str, Any]:
    """Records that many hours to `path`, and opens it."""
    iteration_ms, flush_ms, work_ms = write(path, round(hours * 3600.0 / ITERATION_PERIOD_S))
    count, written = len(iteration_ms), path.stat().st_size
    return {
        "iterations": count,
        "log_one_iteration_ms": _spread(iteration_ms),
        "of_which_processor_ms": _spread(work_ms),
        "flush_ms": _spread(flush_ms),
        "megabytes": round(written / 1e6, 1),
        "kilobytes_per_iteration": round(written / 1e3 / count, 2),
        "of_which_raw_signals_kilobytes": round(_raw_bytes(path) / 1e3 / count, 2),
        "open_seconds": _opened(path),
    }


def write(path: Path, count: int) -> tuple[Array, Array, Array]:
    """Records `count` iterations; the times to log each, to bring it to the file, of the thread alone [ms]."""
    recorder = Recorder(blueprint(DARK), path=path)
    pages = RecordingPages(recorder, DARK, Choice(), rate=0.25)
    node = LearnerNode(
        read(None, {"state": None, "signals": {"sample_period": ITERATION_PERIOD_S / BATCH_SAMPLES}}), "a benchmark"
    )
    iteration_ms: list[float] = []
    flush_ms: list[float] = []
    work_ms: list[float] = []
    for start in map(float, range(round((count + 2) * ITERATION_PERIOD_S))):
        for name, (t, value) in _second(start).items():
            node.push(name, t, value)
            pages.measured(name, Measurement(t=tuple(t.tolist()), value=tuple(value.tolist())), start)
        pages.flush()
        while (outcome := node.learn()) is not None and len(iteration_ms) < count:
            report = outcome.report
            began, idle = time.perf_counter(), time.thread_time()
            pages.iteration(Frame(report, outcome.snapshot, start))
            logged = time.perf_counter()
            work_ms.append(1e3 * (time.thread_time() - idle))
            pages.flush()
            iteration_ms.append(1e3 * (logged - began))
            flush_ms.append(1e3 * (time.perf_counter() - logged))
            counters = {"iterations": report.iteration, "samples": 50 * report.iteration, "rejected": 0}
            pages.health(
                Health(level="OK", boot="a benchmark", counters=counters, revision=report.revision, t=report.t), start
            )
        if len(iteration_ms) % 200 == 0 and start % 1000 == 0:
            print(f"{len(iteration_ms)} of {count} iterations", file=sys.stderr)
    recorder.close()
    return np.array(iteration_ms), np.array(flush_ms), np.array(work_ms)


_RUN = {name: values for name, values in recording("T1", 1).streams().items() if name in ("yaw_rate", "torque")}
_RUN_LENGTH_S = 420.0


def _second(start: float) -> dict[str, tuple[Array, Array]]:
    """One second of measurements from `start` [s] on, T1 over and over."""
    lap = start // _RUN_LENGTH_S * _RUN_LENGTH_S
    found = {}
    for name, (t, value) in _RUN.items():
        inside = (t >= start - lap) & (t < start - lap + 1.0) & (t < _RUN_LENGTH_S)
        found[name] = t[inside] + lap, value[inside]
    return found


def _spread(values: Array) -> dict[str, float]:
    # The first iterations also draw the axes, each time that the run widens its range.
    settled = values[len(values) // 20 :]
    return {
        "median": round(float(np.median(settled)), 2),
        "p99": round(float(np.percentile(settled, 99)), 2),
        "longest_of_all": round(float(values.max()), 1),
    }


def _raw_bytes(path: Path) -> int:
    """What the raw signals take of the file: its size less that of the file without them."""
    rest = path.with_suffix(".rest.rrd")
    dropped = ["--drop-entity", "/signals/yaw_rate/raw", "--drop-entity", "/signals/torque/raw"]
    subprocess.run([archive.BINARY, "rrd", "filter", *dropped, path, "-o", rest], check=True, capture_output=True)
    size = path.stat().st_size - rest.stat().st_size
    rest.unlink()
    return size


def _opened(path: Path) -> float | str:
    """From the start of the viewer's process to its first whole picture [s]."""
    began = time.perf_counter()
    try:
        with Screen(path) as screen:
            screen.picture()
            return round(time.perf_counter() - began, 1)
    except BadInput as error:
        return str(error)


def main(words: Sequence[str] | None = None) -> None:
    parser = options("benchmarks.service.recording", __doc__, hours=(10.0, "of the vehicle's time"))
    args, measured = begin(parser, words, "rerun-sdk")
    with tempfile.TemporaryDirectory() as folder:
        result = measure(Path(folder) / "run.rrd", args.hours)
    print(write_result(args.out, "recording", {"measured": measured, "hours": args.hours, **result}), end="")


if __name__ == "__main__":
    main()
