"""The page Before and after, Fig. 8: two revisions of the model in one plot, each with its support vectors.

Where both are chosen, with the samples of both experiments, too: those up to the first, and those from there on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viewer import palette
from viewer.frame import Floats, Frame, positions
from viewer.learning import dashes, labels
from viewer.recorder import Recorder
from viewer.texts import compared
from viewer.xy_plot import Plot, Sign

MAX_SAMPLES = 1000  # of each of the two at most: the newest
SHOWN = [f"learning/{name}/{what}" for what in ("function", "support", "samples") for name in ("before", "after")]
"""The entities of the page."""


@dataclass(frozen=True, slots=True)
class Choice:
    """Which iterations are compared: None is the first one with a model, and the latest."""

    before: int | None = None
    after: int | None = None

    @property
    def both(self) -> bool:
        """Whether neither moves: any other after would have samples without end."""
        return self.before is not None and self.after is not None


class ComparePage:
    """Logs below learning/before and learning/after."""

    def __init__(self, rec: Recorder, choice: Choice) -> None:
        self._rec, self._choice = rec, choice
        self._chosen: dict[str, Frame] = {}
        self._samples: dict[str, Floats] = {"before": np.empty((0, 2)), "after": np.empty((0, 2))}
        of_samples = ("Samples before", "Samples after") if choice.both else ("", "")
        looks = (
            Sign("Before", palette.BEFORE, line="--", size=2.0, order=26.0),
            Sign("After", palette.FUNCTION, line="-", size=2.0, order=24.0),
            Sign("Its support vectors", palette.BEFORE, "s", order=12.0),
            Sign("Its support vectors", palette.SUPPORT, "o", size=6.0, order=12.0),
            Sign(of_samples[0], (*palette.BEFORE, 110), "o", size=1.8, order=4.0),
            Sign(of_samples[1], (*palette.SUPPORT, 110), "o", size=1.8, order=4.0),
        )
        # The legend goes down its columns: a row for each of the two.
        self._plot = Plot(rec, "learning/compare_axes", dict(zip(SHOWN, looks, strict=True)), labels(rec.words))

    def log(self, frame: Frame, reach: tuple[float, float]) -> None:
        """One iteration on axes that hold `reach`, at the clocks that are set."""
        number, choice, batch = frame.report.iteration, self._choice, frame.report.batch
        if choice.both and number <= (choice.after or 0):
            name = "before" if number <= (choice.before or 0) else "after"
            new = np.column_stack((batch.rate, batch.damping))
            self._samples[name] = np.concatenate((self._samples[name], new))[-MAX_SAMPLES:]
        if frame.model is None:
            return
        before = self._chosen
        if "before" not in before or number == choice.before:
            self._chosen = self._chosen | {"before": frame}
        if choice.after is None or number <= choice.after or "after" not in before:
            self._chosen = self._chosen | {"after": frame}
        self._plot.hold(*reach)
        for name, chosen in self._chosen.items():
            curve = chosen.curve
            self._plot.lines(f"learning/{name}/function", dashes(curve) if name == "before" else [curve])
            self._plot.points(f"learning/{name}/support", positions(chosen.report.support))
            self._plot.points(f"learning/{name}/samples", self._samples[name])
        if self._chosen is not before:
            pair = self._chosen["before"], self._chosen["after"]
            self._rec.write("learning/compared", compared(*pair, self._rec.words))
