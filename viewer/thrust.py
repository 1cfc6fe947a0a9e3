"""The thrust that an effect makes of the command, on the page Effects: a curve tells more than its parameter."""

from __future__ import annotations

import numpy as np

from incsvr.plant.words import AxisWords
from service.wire import EffectsLedger
from viewer import palette
from viewer.frame import Floats
from viewer.learning import dashes, hatch
from viewer.recorder import Recorder
from viewer.xy_plot import Plot, Sign

SHOWN = ("effects/thrust/without", "effects/thrust/with", "effects/thrust/doubt")
"""The entities of the plot."""


class ThrustPlot:
    """Logs below effects/thrust/: of the first effect in force or found that is a curve of the command."""

    def __init__(self, rec: Recorder) -> None:
        looks = (
            Sign("Thrust without the effect", palette.BEFORE, line="--", size=2.0, order=14.0),
            Sign("Thrust with the effect", palette.FUNCTION, line="-", size=2.6, order=22.0),
            Sign("95 % interval", palette.BAND, line="|||", size=0.8, order=1.0),
        )
        self._drawn = False
        self._plot = Plot(rec, "effects/thrust/axes", dict(zip(SHOWN, looks, strict=True)), labels(rec.words))

    def log(self, ledger: EffectsLedger, points: int = 100) -> None:  # of the dashed line
        """What the ledger says, at the clocks that are set; without such an effect the lines of the last one go."""
        curves = [each["thrust_nm"] for each in (*ledger.effects, *ledger.found) if each.get("thrust_nm")]
        if not curves:
            for path in SHOWN if self._drawn else ():
                self._plot.lines(path, [])
            return
        self._drawn = True
        command, *thrusts = np.array(curves[0], dtype=np.float64).T
        made, low, high = (np.column_stack((command, each)) for each in thrusts)
        full = float(np.abs(curves[0]).max())
        self._plot.hold(full, full)
        equal: Floats = np.linspace(command[0], command[-1], points, dtype=np.float64)
        lines = (dashes(np.column_stack((equal, equal))), [made], hatch(low, high))
        for path, drawn in zip(SHOWN, lines, strict=True):
            self._plot.lines(path, drawn)


def labels(words: AxisWords) -> tuple[str, str]:
    """What the two axes are called, with their units."""
    return f"Commanded {words.effort} [{words.effort_unit}]", f"Thrust [{words.effort_unit}]"
