"""One recording of a learner: what comes in, each on the clocks that it belongs to, on every page that shows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
import rerun as rr
from rerun.components import MarkerShape

from service.wire import SETS, Batch, EffectsLedger, Health, Measurement
from viewer import palette, texts
from viewer.compare import Choice, ComparePage
from viewer.frame import Floats, Frame
from viewer.learning import LearningPage, signs
from viewer.names import channel, effect
from viewer.pages import CHANNELS, blueprint
from viewer.recorder import Look, Recorder
from viewer.thrust import ThrustPlot

HEALTH_S = 5.0
COLLECTING = "# Collecting the first samples\n\nThe first iteration comes when a batch is complete."
AWAY = "AWAY"
DAMPING = "damping"
LOOKS: Mapping[str, Look] = {
    "signals/yaw_rate/raw": Look("Raw", palette.BLUE),
    "signals/yaw_rate/synchronised": Look("Smoothed", palette.AMBER, 1.6, MarkerShape.Circle),
    "signals/torque/raw": Look("Raw", palette.ORANGE),
    "signals/damping/synchronised": Look("Sample", palette.AMBER, 2.2, MarkerShape.Circle),
    "signals/damping/predicted": Look("Model before it saw the sample", palette.GREEN, 2.0),
    "signals/residual": Look("Sample − model", palette.RED, 2.6, MarkerShape.Diamond),
    "signals/health/learned": Look("Learned share", palette.GREEN, 2.5),
    "effects/torque/measured": Look("Measured", palette.BLUE, 2.0, MarkerShape.Circle),
    "effects/torque/predicted": Look("Predicted", palette.RED),
}
"""How each series is drawn whose entity is known; of others the name is the title."""


class Recording:
    """Logs what comes in, as long as the learner counts on, and remembers how far it got."""

    def __init__(self, recorder: Recorder, choice: Choice, rate: float) -> None:
        self.recorder = recorder
        self.revision = 0
        self._iteration: int | None = None
        self._vehicle: float | None = None
        self._said: tuple[Any, float] = (None, 0.0)  # what was last logged of the learner's health, and when
        self._level = ""
        self._ledger: EffectsLedger | None = EffectsLedger()  # None once it stands at an iteration
        self._raw: dict[str, list[Floats]] = {}  # what came and is not logged yet, (n, 3): time, value, seen
        self._channels: list[str] = []  # in the order in which they came
        self._laid = 0  # channels that the pages have a plot for
        self._drawn: dict[str, tuple[float, float]] = {}  # by page the ends of the newest batch that is logged [s]
        self._learning = LearningPage(recorder, rate)
        self._compare = ComparePage(recorder, choice)
        self._thrust = ThrustPlot(recorder)
        states = rr.StateConfiguration(
            values=[*texts.LEVELS, AWAY],
            labels=[*texts.LEVELS.values(), "LEARNER AWAY"],
            colors=[palette.SUPPORT, palette.FORGOTTEN, palette.NEW, palette.DISCARDED, palette.OUTLIER],
        )
        recorder.log("signals/health/level", states, static=True)

    def iteration(self, frame: Frame) -> None:
        """One iteration, on every page that shows it."""
        report, recorder = frame.report, self.recorder
        self.revision, self._iteration, self._vehicle = report.revision, report.iteration, report.t
        self._receive()
        recorder.set_clocks(iteration=report.iteration, vehicle=report.t, wall=frame.seen)
        reach = self._learning.log(frame)
        self._compare.log(frame, reach)
        self._errors(frame)
        self._samples("signals", report.batch, residuals(report.batch))
        if report.batch.parts:
            self._samples("effects", report.batch, efforts(report.batch))
        if self._ledger is not None:
            # What was said before the first iteration stands on the clock on the wall alone.
            recorder.write("effects/ledger", texts.ledger(self._ledger, recorder.words))
            self._thrust.log(self._ledger)
            self._ledger = None
        recorder.write("learning/table", texts.iteration(frame, recorder.words))
        recorder.write("learning/samples", texts.samples(frame, {name: signs()[name].text for name in SETS}))
        recorder.log("learning/revision", rr.Scalars(float(report.revision)))

    def measured(self, stream: str, measurement: Measurement, seen: float) -> None:
        """Values of a stream, come in at `seen` [s since 1970]."""
        times, values = np.atleast_1d(measurement.t), np.atleast_1d(measurement.value)
        if not times.size or times.size != values.size:
            return
        self._raw.setdefault(stream, []).append(np.column_stack((times, values, np.full(times.size, seen))))
        if self._vehicle is None:
            self._now(seen, float(times[0]))
            self.recorder.write("learning/table", COLLECTING)

    def health(self, health: Health, seen: float) -> None:
        """The learner's health: where it changes, else every few seconds; it comes once a second."""
        said = (health.level, health.reasons, health.revision, health.counters.get("rejected"))
        if said == self._said[0] and seen - self._said[1] < HEALTH_S:
            return
        self._said = (said, seen)
        self._now(seen, health.t)
        for name, count in health.counters.items():
            if name.startswith("rejected"):
                self._scalar(f"signals/rejected/{name.partition(':')[2] or 'all_reasons'}", float(count))
        self.recorder.write("signals/health/now", texts.health(health, self.recorder.words))
        self._scalar("signals/health/learned", health.learned)
        self._switch(health.level)

    def away(self, sentence: str, seen: float) -> None:
        """The learner does not answer."""
        self._said = (None, 0.0)  # what it says when it is back is news, even where it is the same
        self._now(seen, None)
        self.recorder.write("signals/health/now", f"# LEARNER AWAY\n\n{sentence}")
        self._switch(AWAY)

    def effects(self, ledger: EffectsLedger, seen: float) -> None:
        """The ledger of traced effects."""
        self._now(seen, None)
        self.recorder.write("effects/ledger", texts.ledger(ledger, self.recorder.words))
        self._ledger = ledger

    def flush(self) -> bool:
        """Brings all that came in to the file and the screen; False once the file had to be given up."""
        self._receive()
        if len(self._channels) > self._laid:  # one came: the pages are laid out anew
            self._laid = len(self._channels)
            self.recorder.lay_out(blueprint(channels=self._channels, axis=self.recorder.axis))
        return self.recorder.flush()

    def _receive(self) -> None:
        """Logs what the streams brought since the last time."""
        for name, raw in self._raw.items():
            path = f"signals/{name}/raw"
            if path not in LOOKS:
                path = f"{CHANNELS}/{name}"
                self._channels += [name] if name not in self._channels else []
            self.recorder.series(path, _look(path, channel(name)), *np.concatenate(raw).T)
        self._raw.clear()

    def _samples(self, page: str, batch: Batch, columns: Mapping[str, Floats]) -> None:
        """Series of a batch's samples, on the vehicle's time.

        A learner that changes over to other effects says its last batch again: what it said at the time stands. A batch
        before the newest one is of a clock that restarted.
        """
        time, (first, last) = np.array(batch.time), self._drawn.get(page, (-inf, -inf))
        new = (time > last) | (time[-1:] < first)
        if new.any():
            self._drawn[page] = batch.time[0], batch.time[-1]
            for path, values in columns.items():
                self.recorder.series(path, _look(path), time[new], values[new])

    def _errors(self, frame: Frame) -> None:
        """A curve below error/ for each kind of error (Fig. 7), at the clocks that are set.

        Every curve is of one predictor: what is served, with its continuation beyond the learned rates.
        """
        report, unit = frame.report, self.recorder.words.effort_unit
        if report.progressive_mae is not None:
            self._scalar("error/progressive", report.progressive_mae, "Each new batch")
        for check in report.validation:
            # The untrained model's error would press all others flat: it is in the name.
            untrained = "" if check.untrained is None else f"; untrained: {texts.quantity(check.untrained, unit)}"
            self._scalar(f"error/{check.name}", check.mae, f"Validation {check.name}{untrained}")

    def _scalar(self, path: str, value: float, title: str | None = None) -> None:
        self.recorder.scalar(path, _look(path, title), value)

    def _switch(self, level: str) -> None:
        if level != self._level:
            self._level = level
            self.recorder.log("signals/health/level", rr.StateChange(state=level))

    def _now(self, seen: float, vehicle: float | None) -> None:
        """The clocks of what belongs to no iteration: it stands at the newest one."""
        if vehicle is not None:
            self._vehicle = max(vehicle, self._vehicle or vehicle)
        self.recorder.set_clocks(iteration=self._iteration, vehicle=self._vehicle, wall=seen)


def _look(path: str, title: str | None = None) -> Look:
    """How a series looks: as the table says, else a plain line under its title or its name in words."""
    return LOOKS.get(path) or Look(title or effect(path.rpartition("/")[2]))


def residuals(batch: Batch) -> dict[str, Floats]:
    """Entity → (n,) rates [rad/s], damping and residual [N m] of a batch's samples."""
    damping = np.array(batch.damping)
    found = {"signals/yaw_rate/synchronised": np.array(batch.rate), "signals/damping/synchronised": damping}
    if batch.predicted is not None:
        predicted = np.array(batch.predicted)
        found |= {"signals/damping/predicted": predicted, "signals/residual": damping - predicted}
    return found


def efforts(batch: Batch) -> dict[str, Floats]:
    """Entity → (n,) moments [N m]: the torque, measured and predicted, and each part, the damping as predicted.

    The parts add up to the prediction. An effect of a channel is called coupling:sway, which no entity may be.
    """
    parts = {name: np.array(values) for name, values in batch.parts.items()}
    rest = np.sum(list(parts.values()), axis=0)
    found: dict[str, Floats] = {"effects/torque/measured": rest + np.array(batch.damping)}
    if batch.predicted is not None:
        parts[DAMPING] = np.array(batch.predicted)
        found["effects/torque/predicted"] = rest + parts[DAMPING]
    named: Sequence[tuple[str, Floats]] = list(parts.items())
    return found | {f"effects/parts/{name.replace(' ', '_').replace(':', '_')}": part for name, part in named}
