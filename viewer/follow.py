"""Follows one learner: what it says goes onto the pages, what was missed is asked for, what is wrong is said."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

from incsvr.errors import BadInput
from service.wire import EffectsLedger, Health, IterationReport, Measurement
from viewer.bus import Bus, Message, Presence
from viewer.frame import Frame
from viewer.recording import Recording

log = logging.getLogger(__name__)

AWAY_WORDS = (
    "The learner does not answer. Its last model stays on the screen; everything it learns meanwhile is fetched later."
)


class Recordings:
    """The recording that is open, and those before it: a learner or a clock that begins anew gets the next file.

    Nothing is overwritten: where `run.rrd` exists, the recording goes to `run-2.rrd`.

    Args:
        path: of the first; None records nothing.
        opened: a new recording that goes to this file, too.
    """

    def __init__(self, path: Path | None, opened: Callable[[Path | None], Recording]) -> None:
        self._path, self._opened = path, opened
        self.now = self._next()

    def begin(self) -> None:
        """Closes the recording that is open and begins the next: iterations or the vehicle's time would run over its
        own."""
        log.info("a new recording begins")
        self.close()
        self.now = self._next()

    def close(self) -> bool:
        """Closes the file; whether it holds everything."""
        recorder = self.now.recorder
        self.now.flush()
        recorder.close()
        if recorder.path is not None and not recorder.broken:
            size = recorder.path.stat().st_size / 1e6
            log.info("%s: %.2f MB; open it with `incsvr view %s`", recorder.path, size, recorder.path)
        return not recorder.broken

    def _next(self) -> Recording:
        path = self._path
        try:
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
                further = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
                path = path if not _has_data(path) else next(each for each in further if not _has_data(each))
            return self._opened(path)
        except (RuntimeError, OSError) as error:
            raise BadInput(f"{path}: cannot be written ({error}); free some space or record elsewhere") from None


def _has_data(path: Path) -> bool:
    return path.exists() and path.stat().st_size > 0


class Follower:
    """Keeps the recordings in step with what the bus says."""

    def __init__(self, bus: Bus, recordings: Recordings) -> None:
        self._bus, self._recordings = bus, recordings
        self._earliest: float | None = None  # the vehicle's time before which its clock began anew [s]
        self._here = False

    def run(self, stop: threading.Event, *, until_broken: bool, flush_s: float = 1.0) -> None:
        """Follows until `stop` is set, and the bus woken; or until the file is broken, where there is nothing else."""
        self._recording.away("Waiting for the learner.", time.time())
        flushed = time.monotonic()
        while not stop.is_set():
            for message in self._bus.wait(flush_s):
                self._take(message)
            if time.monotonic() - flushed >= flush_s:
                flushed = time.monotonic()
                if not self._recording.flush() and until_broken:
                    return
        # What the learner said before we were told to stop belongs to the recording.
        if self._here:
            self._catch_up()
        for message in self._bus.wait(0.0):
            self._take(message)
        health = self._bus.health() if self._here else None
        if health is not None:
            self._recording.health(health, time.time())

    @property
    def _recording(self) -> Recording:
        return self._recordings.now

    def _take(self, message: Message | Presence) -> None:
        if isinstance(message, Presence):
            self._meet(message.here)
            return
        match message.form:
            case IterationReport() as report:
                self._iteration(report, message.seen)
            case Health() as health:
                if health.revision > self._recording.revision:
                    self._catch_up()
                self._recording.health(health, message.seen)
            case EffectsLedger() as ledger:
                self._recording.effects(ledger, message.seen)
            case Measurement() as measurement:
                self._recording.measured(message.stream, measurement, message.seen)

    def _meet(self, here: bool) -> None:
        if here == self._here:
            return
        self._here = here
        if not here:
            log.warning("the learner does not answer; waiting for it")
            self._recording.away(AWAY_WORDS, time.time())
            return
        log.info("the learner is here")
        health = self._bus.health()
        if health is not None and health.revision < self._recording.revision:
            self._recordings.begin()
            self._earliest = None
        self._catch_up()
        ledger = self._bus.ledger()
        if ledger is not None:
            self._recording.effects(ledger, time.time())

    def _iteration(self, report: IterationReport, seen: float) -> None:
        if report.revision <= self._recording.revision:
            return
        if report.revision > self._recording.revision + 1:
            self._catch_up(before=report.revision)
        self._show(report, seen)

    def _catch_up(self, before: int | None = None) -> None:
        """Shows the iterations that were missed, those below revision `before`."""
        for report in self._bus.reports(self._recording.revision):
            if before is not None and report.revision >= before:
                return
            self._show(report, None)
        self._recording.flush()

    def _show(self, report: IterationReport, seen: float | None) -> None:
        if self._earliest is not None and report.t < self._earliest:
            log.warning("the vehicle's clock restarted at %.1f s", report.t)
            self._recordings.begin()
        # A learner that changes over to other effects says its last batch again, and that may end some samples earlier.
        self._earliest = report.t - 0.5 * max(report.t - report.time_span[0], 0.0)
        self._recording.iteration(Frame(report, self._bus.model(report), seen))
        self._recording.flush()  # whatever happens to us from here on, it is in the file
        log.info("iteration %d at %.1f s", report.iteration, report.t)
