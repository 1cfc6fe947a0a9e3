"""The error curves, Fig. 7: how far the served damping is off, iteration by iteration.

Every curve is of one predictor: what is served, with its continuation beyond the learned rates.
"""

from __future__ import annotations

import rerun as rr

from viewer.frame import Frame
from viewer.recorder import Recorder
from viewer.table import quantity


class ErrorPage:
    """Logs below error/: a curve a kind of error."""

    def __init__(self, rec: Recorder) -> None:
        self._rec = rec

    def log(self, frame: Frame) -> None:
        """One iteration, at the clocks that are set."""
        report, unit = frame.report, self._rec.words.effort_unit
        if report.progressive_mae is not None:
            self._point("progressive", "Each new batch", report.progressive_mae)
        for check in report.validation:
            # The untrained model's error would press all others flat: it stands in the name.
            untrained = "" if check.untrained is None else f"; untrained: {quantity(check.untrained, unit)}"
            self._point(check.name, f"Validation {check.name}{untrained}", check.mae)

    def _point(self, name: str, title: str, value: float) -> None:
        self._rec.line(f"error/{name}", title)
        self._rec.log(f"error/{name}", rr.Scalars(value))
