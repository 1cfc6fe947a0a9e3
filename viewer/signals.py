"""The page Signals, and the scope: what came in, what became samples, what the model left over, what was refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
import rerun as rr
from rerun.components import InterpolationMode, MarkerShape

from viewer.axes import Axes, Entry, NumberedAxis, axis_for, even_axis
from viewer.component_batches import dashed, scalars, strips
from viewer.frame import VEHICLE_TIME, WALL_TIME, Floats, Frame
from viewer.learning import log_axes, log_transform
from viewer.names import channel
from viewer.palette import LIGHT, Palette
from viewer.pauses import MIN_PAUSE_S, Pauses
from viewer.recorder import Recorder

SCOPE_S = 60.0  # s
MAX_SCOPE_POINTS = 240  # of a stream in the scope at most
WIDTH, HEIGHT = 1000, 425
ALL = "all_reasons"
HINT = "signals/clock"
CHANNELS = "signals/channel"
PREDICTED = "signals/damping/predicted"
SWITCH = "# Choose *vehicle_time* below\n\nThe signals run on the vehicle's time, in the list at the lower left."
ON_TIME = (
    "All on the vehicle's time. Raw: as it came in. Synchronised: on the learner's grid, smoothed, from its own stamps."
)
DASH_S = {"yaw_rate": None, "torque": 1.1}  # s; None is a solid line
UNITS = {"yaw_rate": "rad/s", "torque": "N m"}


@dataclass
class Raw:
    """What a stream brought: not logged yet, and the last SCOPE_S seconds for the scope."""

    time: list[float] = field(default_factory=list)
    value: list[float] = field(default_factory=list)
    seen: list[float] = field(default_factory=list)
    recent: Floats = field(default_factory=lambda: np.empty((0, 2)))
    pauses: Pauses = field(default_factory=Pauses)


class SignalsPage:
    """Logs below signals/."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec, self._palette = rec, palette
        self._raw: dict[str, Raw] = {}
        self.channels: list[str] = []  # in the order in which they came
        self._predicted = Pauses()
        self._axes: Axes | None = None
        self._reach = {"yaw_rate": 0.0, "torque": 0.0}
        self._rejected: dict[str, int] = {}
        self._explained = False
        self._drawn = -inf  # the vehicle's time of the newest sample that is logged [s]
        # The viewer's own plots follow its theme: these colours are read on white and on black.
        series = LIGHT
        self._refusals = (series.discarded, series.new, series.forgotten, series.old, series.outlier, series.support)
        line, dot = rec.line, rec.dots
        line("signals/yaw_rate/raw", series.old, "Raw", 1.5)
        dot("signals/yaw_rate/synchronised", series.forgotten, "Synchronised", MarkerShape.Circle, 1.6)
        line("signals/torque/raw", series.before, "Raw", 1.5)
        dot("signals/damping/synchronised", series.forgotten, "Sample", MarkerShape.Circle, 2.2)
        line(PREDICTED, series.support, "Model before it saw the sample", 2.0)
        dot("signals/residual", series.new, "Sample - model", MarkerShape.Diamond, 2.6)
        for name, colour, radius in (("yaw_rate", palette.old, 1.6), ("torque", palette.before, 1.2)):
            rec.strip(f"signals/scope/{name}", colour, radius, 5.0)

    def receive(self, name: str, time: Sequence[float], value: Sequence[float], seen: float) -> None:
        """Takes (n,) stamps of the vehicle [s] and values of a stream, come in at `seen` [s since 1970]."""
        raw = self._raw.setdefault(name, Raw())
        raw.time.extend(time)
        raw.value.extend(value)
        raw.seen.extend([seen] * len(time))

    def explain(self, iteration: int, vehicle: float) -> None:
        """Says on which clock the page runs: on the clock of iterations its plots would be empty without a word."""
        if self._explained:
            return
        self._explained = True
        self._rec.set_clocks(iteration=iteration)
        self._rec.write(HINT, SWITCH)
        self._rec.set_clocks(vehicle=vehicle)
        self._rec.write(HINT, ON_TIME)

    def flush(self) -> None:
        """Logs what came in since the last time."""
        for name, raw in self._raw.items():
            if not raw.time:
                continue
            path = f"signals/{name}/raw" if name in UNITS else f"{CHANNELS}/{name}"
            if name not in UNITS and name not in self.channels:
                self.channels.append(name)
                self._rec.line(path, self._refusals[len(self.channels) % len(self._refusals)], channel(name), 1.5)
            times, values = raw.pauses.broken(np.array(raw.time), np.array(raw.value, dtype=np.float64))
            # A point that ends a line came in with the one after it.
            seen = np.interp(times, raw.time, raw.seen) if len(times) > len(raw.time) else np.array(raw.seen)
            clocks = [rr.TimeColumn(VEHICLE_TIME, duration=times), rr.TimeColumn(WALL_TIME, timestamp=seen)]
            self._rec.send_columns(path, clocks, scalars(values))
            if name in UNITS:
                raw.recent = np.concatenate((raw.recent, np.column_stack((raw.time, raw.value))))
                raw.recent = raw.recent[raw.recent[:, 0] >= raw.recent[:, 0].max() - 2.0 * SCOPE_S]
            raw.time, raw.value, raw.seen = [], [], []

    def log(self, frame: Frame) -> None:
        """One iteration, at the clocks that are set: its samples, and the scope of the last minute."""
        self.flush()
        batch = frame.report.batch
        time = np.array(batch.time)
        # A learner that changes over to other effects says its last batch again: what it said at the time stands.
        new = time > self._drawn
        if new.any():
            columns: dict[str, Sequence[float] | Floats] = {
                "signals/yaw_rate/synchronised": batch.rate,
                "signals/damping/synchronised": batch.damping,
            }
            if batch.predicted is not None:
                columns[PREDICTED] = batch.predicted
                columns["signals/residual"] = np.subtract(batch.damping, batch.predicted)
            for path, values in columns.items():
                at, value = time[new], np.array(values)[new]
                if path == PREDICTED:
                    at, value = self._predicted.broken(at, value)
                self._rec.series(path, at, value)
            self.remember(frame)
        end = frame.report.t
        lines = {name: self._recent(name, end) for name in UNITS}
        if not len(lines["yaw_rate"]) and batch.time:
            # From before we came: the synchronised samples are all that is left of it.
            lines["yaw_rate"] = np.column_stack((np.array(batch.time) - end, batch.rate))
        self._follow(lines)
        for name, line in lines.items():
            self._rec.log(
                f"signals/scope/{name}",
                strips([dash for part in unbroken(line) for dash in dashed(part, DASH_S[name])]),
            )

    def remember(self, frame: Frame) -> None:
        """The samples of this iteration are logged."""
        if frame.report.batch.time:
            self._drawn = frame.report.batch.time[-1]

    def reject(self, counters: Mapping[str, int]) -> None:
        """The refused samples so far, altogether and by reason, at the clocks that are set."""
        reasons = {name.removeprefix("rejected:"): count for name, count in counters.items() if "rejected:" in name}
        counts = {ALL: sum(reasons.values()), **reasons}
        for reason in counts.keys() - self._rejected.keys():
            colour = self._refusals[len(self._rejected) % len(self._refusals)]
            style = rr.SeriesLines(
                colors=colour,
                names=reason.replace("_", " ").capitalize(),
                widths=2.0,
                interpolation_mode=InterpolationMode.StepAfter,
            )
            self._rec.log(f"signals/rejected/{reason}", style, static=True)
            self._rejected[reason] = 0
        self._rejected.update(counts)
        for reason, count in self._rejected.items():
            self._rec.log(f"signals/rejected/{reason}", rr.Scalars(float(count)))

    def _recent(self, name: str, end: float) -> Floats:
        """The last minute of a stream up to `end`, as seconds before it and values, thinned to what a screen shows."""
        raw = self._raw.get(name)
        if raw is None:
            return np.empty((0, 2))
        inside = raw.recent[(raw.recent[:, 0] > end - SCOPE_S) & (raw.recent[:, 0] <= end)]
        return thinned(inside - np.array([end, 0.0]))

    def _follow(self, lines: Mapping[str, Floats]) -> None:
        """Widens the scope's axes where a stream needs it."""
        reach = {
            name: max(self._reach[name], float(np.abs(line[:, 1]).max(initial=0.0))) for name, line in lines.items()
        }
        axes = self._axes
        if axes is not None and axes.y_right is not None and _holds(axes, axes.y_right, reach):
            return
        self._reach = reach
        palette, words = self._palette, self._rec.words
        self._axes = axes = Axes(
            axis_for(-SCOPE_S, 0.0, "Vehicle time before the end of the iteration [s]", ticks=6),
            even_axis(1.3 * reach["yaw_rate"], f"{words.rate_title} [{words.rate_unit}]"),
            WIDTH,
            HEIGHT,
            legend=(
                (
                    Entry("line", palette.old, f"{words.rate_title}, left"),
                    Entry("dashes", palette.before, f"{words.effort_title}, right"),
                ),
            ),
            y_right=even_axis(1.3 * reach["torque"], f"{words.effort_title} [{words.effort_unit}]"),
        )
        assert axes.y_right is not None
        log_axes(self._rec, "signals/scope/axes", axes, palette, ["signals/scope/yaw_rate"])
        log_transform(self._rec, replace(axes, y=axes.y_right), "signals/scope/torque")


def _holds(axes: Axes, right: NumberedAxis, reach: Mapping[str, float]) -> bool:
    return reach["yaw_rate"] <= axes.y.high and reach["torque"] <= right.high


def unbroken(line: Floats) -> list[Floats]:
    """The (n, 2) line in parts between its pauses: nothing is drawn where nothing came in."""
    return np.split(line, np.flatnonzero(np.diff(line[:, 0]) > MIN_PAUSE_S) + 1)


def thinned(points: Floats) -> Floats:
    """At most MAX_SCOPE_POINTS of (n, 2) points: the lowest and the highest of each slice, so that no peak is lost."""
    if len(points) <= MAX_SCOPE_POINTS:
        return points
    each = -(-len(points) // (MAX_SCOPE_POINTS // 2))
    whole = len(points) // each * each
    blocks = points[:whole, 1].reshape(-1, each)
    starts = np.arange(0, whole, each)
    kept = np.concatenate(
        (starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1), np.arange(whole, len(points)))
    )
    few: Floats = points[np.unique(kept)]
    return few
