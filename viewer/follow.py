"""Follows one learner: what it says goes onto the pages, what was missed is asked for, what is wrong is said."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from service.wire import EffectsLedger, Health, IterationReport, Measurement
from viewer.bus import Bus, Message, Presence
from viewer.frame import Frame
from viewer.recording_pages import RecordingPages

log = logging.getLogger(__name__)

FLUSH_S = 1.0
AWAY_WORDS = (
    "The learner does not answer. Its last model stays on the screen; everything it learns meanwhile is fetched later."
)

Begin = Callable[[], RecordingPages]
"""Closes the present recording, where there is one, and begins the next."""


class Follower:
    """Keeps the recording in step with the learner.

    Args:
        bus: what the learner says.
        pages: where it is recorded.
        begin: begins the next recording, for a learner or a clock that began anew: iterations or the vehicle's time
            would run over those of the present one.
    """

    def __init__(self, bus: Bus, pages: RecordingPages, begin: Begin) -> None:
        self._bus, self._begin = bus, begin
        self._pages = pages
        self._earliest: float | None = None  # the vehicle's time before which its clock began anew [s]
        self._here = False

    def run(self, stop: threading.Event, *, until_broken: bool) -> None:
        """Follows until `stop` is set, and the bus woken; or until the file is broken, where there is nothing else."""
        if not self._here:
            self._pages.away("Waiting for the learner.", time.time())
        flushed = time.monotonic()
        while not stop.is_set():
            for message in self._bus.wait(FLUSH_S):
                self._take(message)
            if time.monotonic() - flushed >= FLUSH_S:
                flushed = time.monotonic()
                if not self._pages.flush() and until_broken:
                    return
        self._finish()

    def _finish(self) -> None:
        """What the learner said before we were told to stop belongs to the recording."""
        if self._here:
            self._catch_up()
        for message in self._bus.wait(0.0):
            self._take(message)
        health = self._bus.health() if self._here else None
        if health is not None:
            self._pages.health(health, time.time())

    def _take(self, message: Message | Presence) -> None:
        if isinstance(message, Presence):
            self._meet(message.here)
            return
        match message.form:
            case IterationReport() as report:
                self._iteration(report, message.seen)
            case Health() as health:
                if health.revision > self._pages.revision:
                    self._catch_up()
                self._pages.health(health, message.seen)
            case EffectsLedger() as ledger:
                self._pages.effects(ledger, message.seen)
            case Measurement() as measurement:
                self._pages.measured(message.stream, measurement, message.seen)

    def _meet(self, here: bool) -> None:
        if here == self._here:
            return
        self._here = here
        if not here:
            log.warning("the learner does not answer; waiting for it")
            self._pages.away(AWAY_WORDS, time.time())
            return
        log.info("the learner is here")
        health = self._bus.health()
        if health is not None and health.revision < self._pages.revision:
            self._pages, self._earliest = self._begin(), None
        self._catch_up()
        ledger = self._bus.ledger()
        if ledger is not None:
            self._pages.effects(ledger, time.time())

    def _iteration(self, report: IterationReport, seen: float) -> None:
        if report.revision <= self._pages.revision:
            return
        if report.revision > self._pages.revision + 1:
            self._catch_up(before=report.revision)
        self._show(report, seen)

    def _catch_up(self, before: int | None = None) -> None:
        """Shows the iterations that were missed, those below revision `before`."""
        for report in self._bus.reports(self._pages.revision):
            if before is not None and report.revision >= before:
                return
            self._show(report, None)
        self._pages.flush()

    def _show(self, report: IterationReport, seen: float | None) -> None:
        if self._earliest is not None and report.t < self._earliest:
            log.warning("the vehicle's clock restarted at %.1f s", report.t)
            self._pages = self._begin()
        # A learner that changes over to other effects says its last batch again, and that may end some samples earlier.
        self._earliest = report.t - 0.5 * max(report.t - report.time_span[0], 0.0)
        frame = Frame(report, self._bus.model(report), seen)
        self._pages.iteration(frame)
        self._pages.flush()  # whatever happens to us from here on, it is in the file
        log.info("iteration %d at %.1f s", report.iteration, report.t)
