"""A router and a learner that are restarted in turn, under a vehicle that goes on sending."""

from __future__ import annotations

import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from benchmarks.service.bus import PARTNERS, process
from benchmarks.service.hold.row import Row
from benchmarks.service.hold.subject import Subject, fed
from service.bus.session import free_endpoint


def restarts(times: int) -> list[Row]:
    """So many of each; after each the next iteration must come."""
    endpoint = free_endpoint()
    rows: dict[str, list[float]] = {"router": [], "learner": []}
    with ExitStack() as stack:
        state = stack.enter_context(tempfile.TemporaryDirectory())
        router = stack.enter_context(ExitStack())
        router.enter_context(process(PARTNERS, "router", endpoint))
        subject = stack.enter_context(Subject(Path(state), router=endpoint))
        stack.enter_context(fed(endpoint))
        for turn in range(2 * times):
            subject.wait_for(max(subject.published, default=0) + 1)
            began = time.monotonic()
            before = max(subject.published)
            if turn % 2:
                subject.stop()
                subject.start()
                before = max(subject.published)
            else:
                router.close()
                router.enter_context(process(PARTNERS, "router", endpoint))
            subject.wait_for(before + 1)
            rows["learner" if turn % 2 else "router"].append(time.monotonic() - began)
        lost, wrong = subject.wrong_answers(sorted(subject.published))
        wrong += subject.twice
        seen = len(subject.published)
    remark = f"of {seen} published revisions, asked for at the end; time until the next iteration"
    return [
        Row(
            f"{what} restarted under a running stream",
            times,
            lost if what == "learner" else 0,
            wrong if what == "learner" else 0,
            until,
            remark,
        )
        for what, until in rows.items()
    ]
