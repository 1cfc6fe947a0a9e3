"""Follows one learner: what it says goes onto the pages, what was missed is asked for, what is wrong is said."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

from incsvr.errors import BadInput
from service.wire import EffectsLedger
from viewer.bus import Questions, Streams
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
    """Keeps the recordings in step with a learner."""

    def __init__(self, learner: Questions, streams: Streams, recordings: Recordings) -> None:
        self._learner, self._streams, self._recordings = learner, streams, recordings
        self._earliest: float | None = None  # the vehicle's time before which its clock began anew [s]
        self._here: bool | None = None  # None before it was asked
        self._ledger: EffectsLedger | None = None

    def run(self, stop: threading.Event, *, until_broken: bool, period_s: float = 1.0) -> None:
        """Follows until `stop` is set, or until the file is broken, where there is nothing else.

        What the learner said before we were told to stop belongs to the recording.
        """
        while True:
            ended = stop.wait(period_s)
            for stream, measurement, seen in self._streams.take():
                self._recordings.now.measured(stream, measurement, seen)
            try:
                self._look()
            except BadInput as error:
                self._meet(False, str(error))
            whole = self._recordings.now.flush()
            if ended or (not whole and until_broken):
                return

    def _look(self) -> None:
        """Asks for what is new.

        Raises:
            BadInput: what answers is no learner of this version.
        """
        health, seen = self._learner.health(), time.time() if self._here else None
        self._meet(health is not None, AWAY_WORDS)
        if health is None:
            return
        if health.revision < self._recordings.now.revision:
            self._begin()
        if health.revision > self._recordings.now.revision:
            for report in self._learner.reports(self._recordings.now.revision):
                self.show(Frame(report, self._learner.model(report.revision), seen))
        ledger = self._learner.ledger()
        if ledger is not None and ledger != self._ledger:
            self._ledger = ledger
            self._recordings.now.effects(ledger, time.time())
        self._recordings.now.health(health, time.time())

    def show(self, frame: Frame) -> None:
        """The next iteration; where the vehicle's clock restarted, in a recording of its own."""
        report = frame.report
        if self._earliest is not None and report.t < self._earliest:
            log.warning("the vehicle's clock restarted at %.1f s", report.t)
            self._begin()
        # A learner that changes over to other effects says its last batch again, and that may end some samples earlier.
        self._earliest = report.t - 0.5 * max(report.t - report.time_span[0], 0.0)
        self._recordings.now.iteration(frame)
        self._recordings.now.flush()  # whatever happens to us from here on, it is in the file
        log.info("iteration %d at %.1f s", report.iteration, report.t)

    def _begin(self) -> None:
        self._recordings.begin()
        self._earliest = self._ledger = None

    def _meet(self, here: bool, why: str) -> None:
        """The learner answers, or does not, and why."""
        if here == self._here:
            return
        if here:
            log.info("the learner is here")
        elif self._here is not None:
            log.warning("the learner does not answer; waiting for it")
            self._recordings.now.away(why, time.time())
        self._here = here
