"""The process beside the learner, for health: what ends it without an answer, how often, how long it works."""

from __future__ import annotations

import time
from collections.abc import Callable

from service.live.tracing_process import DEADLINE_S
from service.live.tracing_state import Work

LONG_WORK_S = 120.0
"""The time after which a piece of work is told [s], by the clock on the wall: the slowest trace known took 24."""
_WORK_NAMES = {"trace": "the tracing process", "prove": "the proof in the tracing process"}
_CURE = "check memory and processor time (`dmesg`); a shorter tracing.window needs less of both"


class WorkerWatch:
    """The worker of one learner. `begin`, `end` and `fail` are called by the thread that learns, `notices` by any.

    Args:
        clock: a monotonic clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._work: tuple[Work, float] | None = None
        self._deaths = 0
        self._death = ""

    def begin(self, work: Work) -> None:
        """A piece of work begins."""
        self._work = work, self._clock()

    def end(self) -> None:
        """Notes that the worker gave a result, even one that the data do not suffice."""
        self._work, self._deaths = None, 0

    def fail(self, work: Work, why: str) -> None:
        """There will be no answer."""
        self._work, self._deaths = None, self._deaths + 1
        self._death = f"{_WORK_NAMES[work]} gave no result: {why}"

    def notices(self) -> tuple[str, ...]:
        """The sentences on present faults."""
        found, work = [], self._work
        if self._deaths:
            often = "once" if self._deaths == 1 else f"{self._deaths} times one after the other"
            found.append(f"{self._death} ({often}); no effect is found or proven meanwhile; {_CURE}")
        if work is not None and (age := self._clock() - work[1]) > LONG_WORK_S:
            found.append(
                f"{_WORK_NAMES[work[0]]} has run for {age:.0f} s and is stopped after {DEADLINE_S:.0f} s; {_CURE}"
            )
        return tuple(found)
