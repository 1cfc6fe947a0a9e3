"""The page Before and after, Fig. 8: two revisions of the model in one plot, each with its support vectors.

Where both are chosen, with the samples of both experiments, too: those up to the first, and those from there on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import rerun as rr
from rerun.components import Radius

from viewer.axes import Axes, Entry
from viewer.component_batches import boxes, points, strips
from viewer.curve import CURVE_STEP, trained_part
from viewer.frame import Floats, Frame, clock_text, positions
from viewer.learning import log_axes
from viewer.palette import Palette
from viewer.recorder import Recorder
from viewer.table import quantity

MAX_SAMPLES = 1000  # of each of the two at most: the newest


@dataclass(frozen=True, slots=True)
class Choice:
    """Which iterations are compared: None is the first one with a model, and the one that the page Learning shows."""

    before: int | None = None
    after: int | None = None

    @property
    def shown(self) -> list[str]:
        """The entities of the page. Without a choice, after is what the page Learning draws, on the same axes."""
        if self.after is None:
            after = ["learning/uncertainty", "learning/function", "learning/extrapolation", "learning/support"]
        else:
            after = ["learning/after/function", "learning/after/support"]
        samples = [] if self.after is None else ["learning/before/samples", "learning/after/samples"]
        return ["learning/compare_axes", *samples, "learning/before/function", "learning/before/support", *after]


class ComparePage:
    """Logs below learning/before and learning/after."""

    def __init__(self, rec: Recorder, palette: Palette, choice: Choice) -> None:
        self._rec, self._palette, self._choice = rec, palette, choice
        self._chosen: dict[str, Frame] = {}
        self._samples = {"before": np.empty((0, 2)), "after": np.empty((0, 2))}
        self._axes: Axes | None = None
        for name, colour in (("before", palette.before), ("after", palette.support)):
            rec.points(f"learning/{name}/samples", (*colour, 110), 1.8, 4.0)
        for name, colour in (("before", palette.before), ("after", palette.function)):
            rec.strip(f"learning/{name}/function", colour, 2.0, 26.0)
        rec.log(
            "learning/before/support",
            rr.Points2D.from_fields(colors=palette.before, radii=Radius.ui_points(1.5), draw_order=12.0),
            rr.Boxes2D.from_fields(colors=palette.before, radii=Radius.ui_points(1.0), draw_order=12.0),
            static=True,
        )
        rec.points("learning/after/support", palette.support, 6.0, 10.0)

    def log(self, frame: Frame, axes: Axes) -> None:
        """One iteration on the axes of the page Learning, at the clocks that are set."""
        number, choice = frame.report.iteration, self._choice
        self._take(frame)
        if frame.model is None:
            return
        changed = set()
        if "before" not in self._chosen or number == choice.before:
            changed.add("before")
        if choice.after is None or number <= choice.after or "after" not in self._chosen:
            changed.add("after")
        self._chosen |= dict.fromkeys(changed, frame)
        if axes is not self._axes:
            self._axes = axes
            changed = set(self._chosen)
            log_axes(self._rec, "learning/compare_axes", self._picture(), self._palette, choice.shown[1:])
        drawn = changed if choice.after is not None else changed - {"after"}
        for name in sorted(drawn):
            self._draw(name, self._chosen[name], axes)
        if changed:
            self._rec.write("learning/compared", words(self._chosen, self._rec.words.effort_unit))

    def _take(self, frame: Frame) -> None:
        """The iteration's samples, where both revisions are chosen: any other after would be drawn without end."""
        number, choice, batch = frame.report.iteration, self._choice, frame.report.batch
        if choice.before is None or choice.after is None or number > choice.after:
            return
        name = "before" if number <= choice.before else "after"
        new = np.column_stack((batch.rate, batch.damping))
        self._samples[name] = np.concatenate((self._samples[name], new))[-MAX_SAMPLES:]

    def _draw(self, name: str, frame: Frame, axes: Axes) -> None:
        curve, at = curve_of(frame, axes), positions(frame.report.support)
        samples = [points(at)]
        if name == "before":
            samples.append(boxes(at, axes.size(8.0)))
        lines = [curve[k : k + 4] for k in range(0, len(curve) - 1, 5)] if name == "before" else [curve]
        self._rec.log(f"learning/{name}/function", strips(lines))
        self._rec.log(f"learning/{name}/support", *samples)
        if self._choice.after is not None:
            self._rec.log(f"learning/{name}/samples", points(self._samples[name]))

    def _picture(self) -> Axes:
        """The axes of the page Learning with this page's words."""
        assert self._axes is not None
        palette = self._palette
        rows: tuple[tuple[Entry, ...], ...] = (
            (),
            (Entry("dashes", palette.before, "Before"), Entry("frame", palette.before, "Its support vectors")),
            (Entry("line", palette.function, "After"), Entry("disc", palette.support, "Its support vectors")),
        )
        if self._choice.after is None:
            last = (
                Entry("band", palette.band, "95 % of samples, after"),
                Entry("dashes", palette.function, "After, extrapolated"),
            )
        else:
            last = (
                Entry("speck", palette.before, "Samples before"),
                Entry("speck", palette.support, "Samples after"),
            )
        return replace(self._axes, legend=(*rows, last))


def curve_of(frame: Frame, axes: Axes) -> Floats:
    """The learned damping within its trained range, (n, 2) [rad/s, N m]."""
    model = frame.model
    assert model is not None
    rate = np.arange(axes.x.low, axes.x.high, axes.size(CURVE_STEP)[0], dtype=np.float64)
    rate = trained_part(rate, model)
    return np.column_stack((rate, model.predict(rate).damping))


def words(chosen: dict[str, Frame], unit: str) -> str:
    """The two revisions side by side, as Markdown."""
    before, after = (chosen[name] for name in ("before", "after"))
    assert after.model is not None
    rate, damping = before.curve.T
    apart = np.abs(after.model.predict(rate).damping - damping)

    def row(text: str, *cells: str) -> str:
        return f"| {text} | {' | '.join(cells)} |"

    pair = (before.report, after.report)
    return "\n".join(
        [
            f"# Iteration {before.report.iteration} and {after.report.iteration}",
            f"Difference {quantity(apart.max(), unit)} at most, {quantity(apart.mean(), unit)} on average, where "
            "the first was trained.",
            "",
            row("", "Before", "After"),
            "|:--|--:|--:|",
            row("Revision", *(str(report.revision) for report in pair)),
            row("Vehicle time", *(clock_text(report.t) for report in pair)),
            row("Support vectors", *(str(len(report.support)) for report in pair)),
            row("Error before learning", *(quantity(report.progressive_mae, unit) for report in pair)),
            *(
                row(f"Error on {check.name}", quantity(check.mae, unit), quantity(other.mae, unit))
                for check, other in zip(*(report.validation for report in pair), strict=False)
            ),
            row("Noise of a sample", *(quantity(report.sigma, unit) for report in pair)),
            row("Off the optimum at most", *(quantity(report.certified_error, unit) for report in pair)),
        ]
    )
