"""A day at sea in minutes: does the learner's memory stay bounded, does it answer throughout, is anything lost?

`make soak`, or `python -m benchmarks.service.soak --minutes 60`. The learner is `incsvr serve` in a process of its
own, with its durable state on disk; Leng's run comes again and again, some hundred times faster than on the vehicle.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from typing import Any

import numpy as np

from benchmarks.service.bus import KEYS, PARTNERS, Learner, learner, process
from benchmarks.study import RESULTS, provenance
from service.wire.json_text import json_text

RESULT = RESULTS / "soak.json"
EVERY = 5.0
"""[s] between two looks."""
SETTLED = 0.2
"""Part of the run after which what is allocated once has been, in a run of five minutes and more."""
MESSAGES = 25
"""Of each stream in a batch. The rings of measurements (`service.bus.ingest.RING_PLACES`) become resident place by
place, 2 MB each: with one message in a batch that takes a whole soak, on a vehicle at 50 Hz three minutes."""


def soak(minutes: float, pace: float) -> dict[str, Any]:
    """Feeds `pace` batches of samples a second for so long, and looks at the learner every few seconds."""
    looks: list[tuple[float, float, int]] = []
    waits: list[float] = []
    with learner() as subject, process(PARTNERS, "feed", subject.endpoint, str(pace), str(MESSAGES)) as feeder:
        assert feeder.stdout is not None
        feeder.stdout.readline()
        began = time.perf_counter()
        while time.perf_counter() - began < 60.0 * minutes:
            time.sleep(EVERY)
            waits.append(_asked(subject))
            health = subject.health()
            resident = subject.process.memory_info().rss / 1e6
            looks.append((time.perf_counter() - began, resident, health.iteration))
        health = subject.health()
    at, resident_mb, iterations = (np.array(values, dtype=np.float64) for values in zip(*looks, strict=True))
    settled = at > SETTLED * at[-1]
    growth = float(np.polyfit(iterations[settled], resident_mb[settled], 1)[0])
    return {
        "minutes": minutes,
        "iterations": int(iterations[-1]),
        "hours_at_sea": round((health.t or 0.0) / 3600.0, 1),
        "resident_mb": {"settled": round(float(resident_mb[settled][0]), 1), "end": round(float(resident_mb[-1]), 1)},
        "growth_mb_per_1000_iterations": round(1000.0 * growth, 3),
        "query_ms": {"median": round(1e3 * float(np.median(waits)), 2), "worst": round(1e3 * max(waits), 2)},
        "level": health.level,
        "reasons": list(health.reasons),
        "counters": health.counters,
    }


def _asked(subject: Learner) -> float:
    """How long the damping at 0.1 rad/s took [s]."""
    began = time.perf_counter()
    replies = list(subject.session.get(f"{KEYS.damping}?rate=0.1"))
    if not replies or replies[0].ok is None:
        raise RuntimeError("the learner does not answer")
    return time.perf_counter() - began


def main() -> int:
    parser = argparse.ArgumentParser(description="Keeps a learner busy; watches memory, answers, losses.")
    parser.add_argument("--minutes", type=float, default=30.0, help="how long (default: %(default)s)")
    parser.add_argument("--pace", type=float, default=10.0, help="batches of samples a second (default: %(default)s)")
    arguments = parser.parse_args()
    found = provenance(shlex.join(["python", "-m", "benchmarks.service.soak", *sys.argv[1:]]), "eclipse-zenoh")
    text = json_text(found | soak(arguments.minutes, arguments.pace), indent=2)
    RESULT.write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
