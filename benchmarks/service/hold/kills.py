"""A power cut at any moment: kill -9, and a start."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.service.bus import KEYS
from benchmarks.service.hold.row import Row
from benchmarks.service.hold.subject import Subject, fed, same
from service.wire import ModelSnapshot

ASKED_REVISIONS = 10
"""Revisions that are asked for after each start."""


def kills(times: int, seed: int) -> Row:
    """Kills a learner that learns five batches a second, and asks the next one for what was published."""
    random = np.random.default_rng(seed)
    lost = wrong = 0
    until = []
    with tempfile.TemporaryDirectory() as state, Subject(Path(state)) as subject, fed(subject.endpoint):
        for _ in range(times):
            subject.wait_for(max(subject.published, default=0) + 1)
            time.sleep(random.uniform(0.0, 0.4))
            subject.kill()
            newest = max(subject.published)
            until.append(subject.start())
            served = subject.ask(KEYS.model, ModelSnapshot)
            # One more may have been saved and not sent; an older one is a loss.
            if served is None or served.revision < newest:
                lost += 1
            elif served.revision == newest and not same(served, subject.published[newest]):
                wrong += 1
            recent = sorted(subject.published)[-ASKED_REVISIONS:]
            missing, otherwise = subject.wrong_answers([each for each in recent if each <= newest])
            lost, wrong = lost + missing, wrong + otherwise
        wrong += subject.twice
        iterations = max(subject.published)
    return Row(
        "kill -9 at a random moment, and a start",
        times,
        lost,
        wrong,
        until,
        f"published revisions that are unknown after the start; {iterations} were published; time until it is ready",
    )
