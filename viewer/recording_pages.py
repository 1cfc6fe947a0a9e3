"""All pages of one recording: a learner's iterations as long as they count on."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path
from typing import Any

import rerun as rr

from incsvr.errors import BadInput
from service.wire import EffectsLedger, Health, Measurement
from viewer.compare import Choice, ComparePage
from viewer.effects import EffectsPage
from viewer.frame import Frame, quantity, samples_table, table
from viewer.learning import LearningPage
from viewer.pages import blueprint
from viewer.palette import Palette
from viewer.recorder import Recorder
from viewer.signals import HealthPage, SignalsPage

log = logging.getLogger(__name__)

HEALTH_S = 5.0
COLLECTING = "# Collecting the first samples\n\nThe first iteration comes when a batch is complete."


class RecordingPages:
    """Logs what comes in, each on the clocks it belongs to, and remembers how far it got."""

    def __init__(self, recorder: Recorder, palette: Palette, choice: Choice, rate: float) -> None:
        self.recorder = recorder
        self.revision = 0
        self._palette = palette
        self._laid: tuple[tuple[str, ...], Mapping[str, str]] = ((), {})
        self._iteration: int | None = None
        self._vehicle: float | None = None
        self._said: tuple[Any, float] = (None, 0.0)  # what was last logged of the learner's health, and when
        self._learning = LearningPage(recorder, palette, rate)
        self._signals = SignalsPage(recorder)
        self._compare = ComparePage(recorder, palette, choice)
        self._health = HealthPage(recorder, palette)
        self._effects = EffectsPage(recorder)

    def iteration(self, frame: Frame) -> None:
        """One iteration, on every page that shows it."""
        report, recorder = frame.report, self.recorder
        self.revision, self._iteration, self._vehicle = report.revision, report.iteration, report.t
        self._signals.explain(report.iteration, report.time_span[0])
        recorder.set_clocks(iteration=report.iteration, vehicle=report.t, wall=frame.seen)
        axes = self._learning.log(frame)
        self._errors(frame)
        self._signals.log(frame)
        self._compare.log(frame, axes)
        self._effects.log(frame)
        recorder.write("learning/table", table(frame, recorder.words))
        recorder.write("learning/samples", samples_table(frame))
        recorder.log("learning/revision", rr.Scalars(float(report.revision)))

    def measured(self, stream: str, measurement: Measurement, seen: float) -> None:
        """Values of a stream, come in at `seen` [s since 1970]."""
        t, value = measurement.t, measurement.value
        times = t if isinstance(t, tuple) else (t,)
        values = value if isinstance(value, tuple) else (value,)
        if not times or len(times) != len(values):
            return
        self._signals.receive(stream, times, values, seen)
        if self._vehicle is None:
            self._now(seen, times[0])
            self.recorder.write("learning/table", COLLECTING)

    def health(self, health: Health, seen: float) -> None:
        """The learner's health: where it changes, else every few seconds; it comes once a second."""
        said = (health.level, health.reasons, health.revision, health.counters.get("rejected"))
        if said == self._said[0] and seen - self._said[1] < HEALTH_S:
            return
        self._said = (said, seen)
        self._now(seen, health.t)
        self._signals.reject(health.counters)
        self._health.log(health)

    def away(self, sentence: str, seen: float) -> None:
        """The learner does not answer."""
        self._said = (None, 0.0)  # what it says when it is back is news, even where it is the same
        self._now(seen, None)
        self._health.away(sentence)

    def effects(self, ledger: EffectsLedger, seen: float) -> None:
        self._now(seen, None)
        self._effects.say(ledger)

    def flush(self) -> bool:
        """Brings all that came in to the file and the screen; False once the file had to be given up."""
        self._signals.flush()
        channels, found = tuple(self._signals.channels), self._effects.found
        if (channels, found) != self._laid:  # one came: the pages are laid out anew
            self._laid = channels, found
            self.recorder.lay_out(blueprint(self._palette, channels=channels, found=found, axis=self.recorder.axis))
        return self.recorder.flush()

    def _errors(self, frame: Frame) -> None:
        """A curve below error/ for each kind of error (Fig. 7), at the clocks that are set.

        Every curve is of one predictor: what is served, with its continuation beyond the learned rates.
        """
        report, unit = frame.report, self.recorder.words.effort_unit
        curves = [("progressive", "Each new batch", report.progressive_mae)]
        for check in report.validation:
            # The untrained model's error would press all others flat: it is in the name.
            untrained = "" if check.untrained is None else f"; untrained: {quantity(check.untrained, unit)}"
            curves.append((check.name, f"Validation {check.name}{untrained}", check.mae))
        for name, title, error in curves:
            if error is not None:
                self.recorder.line(f"error/{name}", title)
                self.recorder.log(f"error/{name}", rr.Scalars(error))

    def _now(self, seen: float, vehicle: float | None) -> None:
        """The clocks of what belongs to no iteration: it stands at the newest one."""
        if vehicle is not None:
            self._vehicle = max(vehicle, self._vehicle or vehicle)
        self.recorder.set_clocks(iteration=self._iteration, vehicle=self._vehicle, wall=seen)


Open = Callable[[Path | None], RecordingPages]
"""Opens the pages of a new recording that goes to this file, too."""


class RecordingSet:
    """The recording that is open, and those before it: a learner or a clock that begins anew gets the next file.

    Nothing is overwritten: where `run.rrd` exists, the recording goes to `run-2.rrd`.
    """

    def __init__(self, path: Path | None, open_pages: Open) -> None:
        self._path, self._open = path, open_pages
        self.pages = self._next()

    def begin(self) -> RecordingPages:
        """Closes the recording that is open and begins the next."""
        log.info("a new recording begins")
        self.close()
        self.pages = self._next()
        return self.pages

    def close(self) -> bool:
        """Closes the file; whether it holds everything."""
        recorder = self.pages.recorder
        self.pages.flush()
        recorder.close()
        if recorder.path is not None and not recorder.broken:
            size = recorder.path.stat().st_size / 1e6
            log.info("%s: %.2f MB; open it with `incsvr view %s`", recorder.path, size, recorder.path)
        return not recorder.broken

    def _next(self) -> RecordingPages:
        path = self._path
        try:
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
                further = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
                path = path if not _has_data(path) else next(each for each in further if not _has_data(each))
            return self._open(path)
        except (RuntimeError, OSError) as error:
            raise BadInput(f"{path}: cannot be written ({error}); free some space or record elsewhere") from None


def _has_data(path: Path) -> bool:
    return path.exists() and path.stat().st_size > 0
