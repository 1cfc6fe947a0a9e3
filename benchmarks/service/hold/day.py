"""A day of data at top speed, with the learner's memory and what it loses."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import psutil

from benchmarks.service.hold.row import Row
from benchmarks.service.hold.subject import Subject, fed

BATCHES_PER_S = 20.0
"""Batches of samples a second: ten minutes of the vehicle each."""


def day(hours: float) -> Row:
    """So many hours of the vehicle's time."""
    with tempfile.TemporaryDirectory() as state, Subject(Path(state)) as subject, fed(subject.endpoint, BATCHES_PER_S):
        assert subject.process is not None
        learner = psutil.Process(subject.process.pid)
        subject.wait_for(1)
        began, settled, peak = time.monotonic(), 0.0, 0.0
        first = subject.health().t or 0.0
        while ((health := subject.health()).t or 0.0) - first < 3600.0 * hours:
            peak = max(peak, learner.memory_info().rss / 1e6)
            if not settled and (health.t or 0.0) - first > 360.0 * hours:
                settled = peak
            time.sleep(1.0)
        took = time.monotonic() - began
    lost = health.counters["rejected"]
    remark = f"{health.iteration} iterations in {took:.0f} s; {settled:.0f} MB after a tenth, {peak:.0f} MB at most"
    return Row(f"{hours:g} h of data at top speed", 1, lost, int(health.level not in ("OK", "WARN")), [], remark)
