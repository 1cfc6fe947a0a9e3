"""How long a question to the learner waits while a process beside it traces, and while none does.

A learner in a process of its own hears Leng's training runs as fast as it takes them; each quarter of the window that
comes begins a trace. Questions for the damping are asked one after the other; those during which the tracing process
lived from beginning to end, and those without one, are counted apart; those during which the learner learned are not
counted.

    python -m benchmarks.service.live_queries
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import psutil

from benchmarks.service.bus import KEYS, PATIENCE_S, Learner, ask, learner, send
from benchmarks.study import provenance

WINDOW_S, PROOF_S = 240.0, 60.0
"""Window and proof of the tracing [s of data]."""
RUNS = 4
"""Training runs of Leng that are played, one after the other."""
MIN_QUESTIONS = 1500
"""Questions of each kind."""


def measure() -> dict[str, Any]:
    """p50 and p99 of a damping query [µs], with and without a trace beside it."""
    waited: dict[bool, list[float]] = {True: [], False: []}
    with learner(**{"tracing.live": "advise", "tracing.window": WINDOW_S, "tracing.proof": PROOF_S}) as subject:
        for run in range(RUNS):
            send(subject, 1 + run, later=1000.0 * run)
            while subject.health().iteration == 0:
                time.sleep(0.1)
            began = time.monotonic()
            while time.monotonic() - began < PATIENCE_S and (run == 0 or _tracing(subject) or not waited[False]):
                _ask(subject, waited)
        while len(waited[False]) < MIN_QUESTIONS:
            _ask(subject, waited)
    return {
        "questions": {"tracing": len(waited[True]), "not": len(waited[False])},
        **{
            f"p{percent}_us": {
                name: float(np.percentile(waited[beside], percent))
                for name, beside in (("tracing", True), ("not", False))
            }
            for percent in (50, 99)
        },
    }


def _tracing(subject: Learner) -> bool:
    """Whether the learner has a process beside it: it starts none but those that trace."""
    try:
        return any(child.status() != psutil.STATUS_ZOMBIE for child in subject.process.children())
    except psutil.NoSuchProcess:  # ended while it was looked at
        return False


def _ask(subject: Learner, waited: dict[bool, list[float]]) -> None:
    """Fifty questions, counted where nothing was learned meanwhile and a trace was beside all of them, or none."""
    iteration, before = subject.health().iteration, _tracing(subject)
    times = [1e6 * ask(subject.session, f"{KEYS.damping}?rate=0.1") for _ in range(50)]
    if before == _tracing(subject) and subject.health().iteration == iteration:
        waited[before] += times


if __name__ == "__main__":
    print(provenance("python -m benchmarks.service.live_queries") | measure())
