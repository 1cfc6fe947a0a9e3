"""How long a question to the learner waits while a process beside it computes, and while that process stands still.

A learner in a process of its own hears Leng's training runs as fast as it takes them; each quarter of the window that
comes begins a trace. While a trace lives, its process is let go and stopped in turns, and questions for the damping are
asked one after the other: what else the machine does is in both kinds of turns. So it is with the process that
identifies the vehicle of a log for the page. Turns in which the learner learned, or the process ended, do not count.

    python -m benchmarks.service.live_queries
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import psutil

from benchmarks.service.bus import KEYS, PATIENCE_S, Learner, ask, learner, send
from benchmarks.study import begin, options
from service.recordings.recording import from_streams
from service.recordings.recording_csv import write
from service.wire.json_text import json_text
from simulator.dive_log import dives
from simulator.vehicles import rov
from viewer.page.identification import Identification

WINDOW_S, PROOF_S = 240.0, 60.0
"""Window and proof of the tracing [s of data]."""
DIVE_S = 300.0
"""Length of the log that is identified [s]."""
QUESTIONS_A_TURN = 100
"""Questions that are asked one after the other, beside the process or without it."""
BOOTSTRAP_ROUNDS = 1000
"""Rounds of the bootstrap over pairs of turns."""

Turns = list[list[list[float]]]
"""Times of questions [µs]: for each pair of turns a list beside the process, and a list without it."""


def measure(pairs: int) -> dict[str, Any]:
    """Percentiles of a damping query [µs] with and without each process beside it, and their ratios."""
    settings = {"tracing.live": "advise", "tracing.window": WINDOW_S, "tracing.proof": PROOF_S}
    with learner(**settings) as subject, TemporaryDirectory() as folder:
        runs = iter(range(1, 1000))

        def teach() -> None:
            run = next(runs)
            send(subject, run, later=1000.0 * run)

        found = {"trace": summary(_turns(subject, subject.process, teach, pairs))}
        path, page, rng = Path(folder, "dive.csv"), Identification(), np.random.default_rng(1)
        write(path, from_streams("dive", dives([rov(rng)], DIVE_S, 1)[0]))
        log = path.read_bytes()
        try:
            identify = partial(page.start, path.name, size=len(log))
            turns = _turns(subject, psutil.Process(), lambda: identify(source=BytesIO(log)), pairs)
            return found | {"identification": summary(turns)}
        finally:
            page.close()


def summary(turns: Turns) -> dict[str, Any]:
    """p50 and p99 of both [µs], and the ratio of each with its interval of 95 % by bootstrap over the pairs."""
    both, random = np.array(turns), np.random.default_rng(1)
    drawn = random.integers(len(both), size=(BOOTSTRAP_ROUNDS, len(both)))
    found: dict[str, Any] = {"pairs": len(both)}
    for percent in (50, 99):
        beside, without = (float(np.percentile(both[:, side], percent)) for side in (0, 1))
        again = [np.percentile(both[places], percent, axis=(0, 2)) for places in drawn]
        low, high = np.percentile([one / other for one, other in again], (2.5, 97.5)).tolist()
        times = {"beside_us": round(beside, 1), "without_us": round(without, 1)}
        found[f"p{percent}"] = times | {
            "ratio": round(beside / without, 3),
            "interval": [round(low, 3), round(high, 3)],
        }
    return found


def _turns(subject: Learner, parent: psutil.Process, start: Callable[[], None], pairs: int) -> Turns:
    """So many pairs of turns beside processes that `start` begins as children of `parent`, one after the other."""
    turns = Turns()
    while len(turns) < pairs:
        start()
        until = time.monotonic() + PATIENCE_S
        while (process := _child(subject, parent)) is None and time.monotonic() < until:
            time.sleep(0.02)
        while process is not None and len(turns) < pairs:
            with suppress(psutil.NoSuchProcess):
                iteration, backwards = subject.health().iteration, len(turns) % 2
                pair = [_turn(subject, process, go) for go in ((False, True) if backwards else (True, False))]
                process.resume()
                if _child(subject, parent) == process and subject.health().iteration == iteration:
                    turns.append(pair[::-1] if backwards else pair)
            process = _child(subject, parent)
    return turns


def _turn(subject: Learner, process: psutil.Process, go: bool) -> list[float]:
    """How long questions take [µs] while the process is let go, or stopped."""
    (process.resume if go else process.suspend)()
    return [1e6 * ask(subject.session, f"{KEYS.damping}?rate=0.1") for _ in range(QUESTIONS_A_TURN)]


def _child(subject: Learner, parent: psutil.Process) -> psutil.Process | None:
    """The process that computes beside the learner."""
    for child in parent.children():
        with suppress(psutil.NoSuchProcess):  # ended while it was looked at
            if child != subject.process and child.status() != psutil.STATUS_ZOMBIE:
                return child
    return None


if __name__ == "__main__":
    parser = options("benchmarks.service.live_queries", __doc__, pairs=(200, "pairs of turns beside each process"))
    given, measured = begin(parser, None, "eclipse-zenoh")
    print(json_text(measured | measure(given.pairs), indent=1))
