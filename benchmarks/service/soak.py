"""A day at sea in minutes: does the learner's memory stay bounded, does it answer throughout, is anything lost?

`make soak`, or `python -m benchmarks.service.soak --minutes 60`. The learner is `incsvr serve` in a process of its
own, with its durable state on disk; Leng's run comes again and again, some hundred times faster than on the vehicle.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.service.bus import KEYS, ask, learner, partner
from benchmarks.study import begin, options, write

LOOK_PERIOD_S = 5.0
"""[s] between two looks."""
SETTLED_SHARE = 0.2
"""Part of the run after which what is allocated once has been, in a run of five minutes and more."""
MESSAGES_PER_BATCH = 25
"""Messages of each stream in a batch. The rings of measurements (`service.bus.ingest.RING_PLACES`) become resident
place by place, 2 MB each: with one message in a batch that takes a whole soak, on a vehicle at 50 Hz three minutes."""


def soak(minutes: float, pace: float) -> dict[str, Any]:
    """Feeds `pace` batches of samples a second for so long, and looks at the learner every few seconds."""
    looks: list[tuple[float, float, int]] = []
    waits: list[float] = []
    with learner() as subject, partner("feed", subject.endpoint, str(pace), str(MESSAGES_PER_BATCH)):
        began = time.perf_counter()
        while time.perf_counter() - began < 60.0 * minutes:
            time.sleep(LOOK_PERIOD_S)
            waits.append(ask(subject.session, f"{KEYS.damping}?rate=0.1"))
            health = subject.health()
            resident = subject.process.memory_info().rss / 1e6
            looks.append((time.perf_counter() - began, resident, health.iteration))
        health = subject.health()
    at, resident_mb, iterations = (np.array(values, dtype=np.float64) for values in zip(*looks, strict=True))
    settled = at > SETTLED_SHARE * at[-1]
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


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.service.soak", __doc__, minutes=(30.0, "how long"), pace=(10.0, "batches of samples a second")
    )
    args, measured = begin(parser, words, "eclipse-zenoh")
    print(write(args.out, "soak", measured | soak(args.minutes, args.pace)), end="")


if __name__ == "__main__":
    main()
