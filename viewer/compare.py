"""The page Before and after, Fig. 8: two revisions of the model in one plot, each with its support vectors.

Where both are chosen, with the samples of both experiments, too: those up to the first, and those from there on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rerun as rr

from viewer.axes import Axes, Sign, place, style
from viewer.frame import Frame, clock_text, markdown_table, positions, quantity
from viewer.palette import Palette
from viewer.recorder import Recorder

MAX_SAMPLES = 1000  # of each of the two at most: the newest
SHOWN = [f"learning/{name}/{what}" for name in ("before", "after") for what in ("samples", "function", "support")]
"""The entities of the page."""


@dataclass(frozen=True, slots=True)
class Choice:
    """Which iterations are compared: None is the first one with a model, and the latest."""

    before: int | None = None
    after: int | None = None


class ComparePage:
    """Logs below learning/before and learning/after."""

    def __init__(self, rec: Recorder, palette: Palette, choice: Choice) -> None:
        self._rec, self._palette, self._choice = rec, palette, choice
        self._chosen: dict[str, Frame] = {}
        self._samples = {"before": np.empty((0, 2)), "after": np.empty((0, 2))}
        self._axes: Axes | None = None
        self._support = {
            "before": Sign("Its support vectors", palette.before, "s"),
            "after": Sign("Its support vectors", palette.support, "o", size=6.0),
        }
        for name, colour, order in (("before", palette.before, 26.0), ("after", palette.function, 24.0)):
            rec.points(f"learning/{name}/samples", (*self._support[name].colour, 110), 1.8, 4.0)
            rec.strip(f"learning/{name}/function", colour, 2.0, order)
            style(rec, f"learning/{name}/support", self._support[name], 12.0)

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
            self._axes, changed = axes, set(self._chosen)
            axes.log(self._rec, "learning/compare_axes", self._palette, self._legend(), SHOWN)
        for name in sorted(changed):
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
        curve = frame.curve
        lines = [curve[k : k + 4] for k in range(0, len(curve) - 1, 5)] if name == "before" else [curve]
        self._rec.log(f"learning/{name}/function", rr.LineStrips2D(lines))
        place(self._rec, f"learning/{name}/support", self._support[name], positions(frame.report.support), axes)
        self._rec.log(f"learning/{name}/samples", rr.Points2D(self._samples[name]))

    def _legend(self) -> list[Sign]:
        """Two columns; with the samples a third."""
        palette, both = self._palette, self._support
        curves = [Sign("Before", palette.before, line="--"), both["before"]]
        curves += [Sign("After", palette.function, line="-"), both["after"]]
        if self._choice.before is None or self._choice.after is None:
            return curves
        return [*curves, *(Sign(f"Samples {name}", sign.colour, "o", size=2.0) for name, sign in both.items())]


def words(chosen: dict[str, Frame], unit: str) -> str:
    """The two revisions side by side, as Markdown."""
    before, after = (chosen[name] for name in ("before", "after"))
    assert after.model is not None
    rate, damping = before.curve.T
    apart = np.abs(after.model.predict(rate).damping - damping)

    pair = (before.report, after.report)
    rows = [
        ("Revision", *(report.revision for report in pair)),
        ("Vehicle time", *(clock_text(report.t) for report in pair)),
        ("Support vectors", *(len(report.support) for report in pair)),
        ("Error before learning", *(quantity(report.progressive_mae, unit) for report in pair)),
        *(
            (f"Error on {check.name}", quantity(check.mae, unit), quantity(other.mae, unit))
            for check, other in zip(*(report.validation for report in pair), strict=False)
        ),
        ("Noise of a sample", *(quantity(report.noise, unit) for report in pair)),
        ("Off the optimum at most", *(quantity(report.certified_error, unit) for report in pair)),
    ]
    head = [
        f"# Iteration {before.report.iteration} and {after.report.iteration}",
        f"Difference {quantity(apart.max(), unit)} at most, {quantity(apart.mean(), unit)} on average, where the first "
        "was trained.\n",
    ]
    return "\n".join([*head, *markdown_table(("", "Before", "After"), rows)])
