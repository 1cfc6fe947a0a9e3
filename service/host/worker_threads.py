"""The threads of the learner's process: few, however many learners it holds, for threads that wait for each other cost.

One takes measurements in, one trains, one answers for models and health, one watches over health; damping is answered
by a thread of each learner. A measurement waits POLL_PERIOD_S at most, which is nothing to a batch of samples; the
damping does not wait.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

from service.host.host import Host
from service.host.shared_streams import share_streams

log = logging.getLogger(__name__)

POLL_PERIOD_S = 0.05
"""The time after which measurements are taken in, and questions for history looked at, again [s]."""
HEALTH_CHECK_PERIOD_S = 0.5
"""The time after which health is looked at again [s]."""


class WorkerThreads:
    """Works for learners from `with` to its end; then they have said goodbye, saved and closed.

    Args:
        hosts: the learners; each tells the velocity of its axis to those of the same vehicle that wait for it.
        stroke: called by the thread that learns, for a watchdog that is to miss it where that thread hangs.
        period: how often at least it is called [s]; None where no watchdog watches.
    """

    def __init__(
        self, hosts: Sequence[Host], stroke: Callable[[], None] = lambda: None, period: float | None = None
    ) -> None:
        self._hosts, self._stroke, self._period = hosts, stroke, period
        share_streams(hosts)
        self._stop, self._batch = threading.Event(), threading.Event()
        self._threads = [
            threading.Thread(target=work, name=work.__name__.strip("_"), daemon=True)
            for work in (self._take_in, self._train, self._answer, self._watch)
        ]

    def __enter__(self) -> Self:
        self._batch.set()  # one may have been waiting when the process before ended
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._each(Host.goodbye)
        self._stop.set()
        self._batch.set()
        for thread in self._threads:
            thread.join()
        self._each(lambda host: host.feed.hear())
        self._each(Host.close)

    def _take_in(self) -> None:
        def hear(host: Host) -> None:
            if host.feed.hear():
                self._batch.set()

        def learn(host: Host) -> None:
            if host.feed.learn():
                self._batch.set()

        while not self._stop.wait(POLL_PERIOD_S):
            # What one hears may be another's, too: each is told all of it before its samples are made.
            self._each(hear)
            self._each(learn)

    def _train(self) -> None:
        while not self._stop.is_set():
            self._batch.wait(self._period)
            self._batch.clear()
            waiting = list(self._hosts)
            while waiting and not self._stop.is_set():
                waiting = [host for host in waiting if self._learn_one(host)]

    def _learn_one(self, host: Host) -> bool:
        """One iteration, where a batch waits; what fails for one learner does not end the learning of the others."""
        if self._period is not None:
            self._stroke()
        try:
            return host.learn()
        except Exception as error:
            log.exception("%s: a fault of this program", host.keys.prefix)
            host.watch.add_failure(f"what was learned could not be published: {error}")
            return False

    def _answer(self) -> None:
        def answer(host: Host) -> None:
            if host.answers.answer():
                self._batch.set()

        while not self._stop.wait(POLL_PERIOD_S):
            self._each(answer)

    def _watch(self) -> None:
        def tick(host: Host) -> None:
            if host.tick():
                self._batch.set()

        while not self._stop.wait(HEALTH_CHECK_PERIOD_S):
            self._each(tick)

    def _each(self, work: Callable[[Host], object]) -> None:
        """Does it for every learner; what fails for one is said and does not end the work for the others."""
        for host in self._hosts:
            try:
                work(host)
            except Exception:
                log.exception("%s: a fault of this program", host.keys.prefix)
