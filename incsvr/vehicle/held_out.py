"""Errors of a vehicle's model on unseen data: other recordings, or each part of these by the others."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.vehicle.fitting import Fit, Windows, fit
from incsvr.vehicle.motion import CELLS_A_SCALE, WholeMotion
from incsvr.vehicle.scales import Scales
from incsvr.vehicle.validation import Errors, errors

WINDOW_CELLS = int(CELLS_A_SCALE)
"""Cells of a window, which lasts the shortest time over which a velocity stays correlated: longer ones end in a local
minimum more often, and predict measured vehicles no better."""
MAX_WINDOWS = 400
"""Windows that are fitted; of more, these are spread evenly: eight minutes of a small ROV have as many."""
MAX_PITCH_RAD = 1.2
"""Pitch up to which windows are fitted: towards a quarter turn roll is lost, and no linear model of a window holds."""
PARTS = 4
"""Parts of the data that are predicted by the others where no other recording is given."""


def spread_windows(motion: WholeMotion) -> Windows:
    """The windows of a motion that are fitted."""
    return Windows(motion, _spread(_level(motion)), WINDOW_CELLS)


def _level(motion: WholeMotion) -> NDArray[np.intp]:
    """First cells of the windows in which the vehicle does not stand on its nose or tail."""
    first = motion.windows(WINDOW_CELLS)
    steep = np.abs(motion.angle[first[:, None] + np.arange(WINDOW_CELLS + 1), 1]).max(axis=1) > MAX_PITCH_RAD
    return np.asarray(first[~steep], dtype=np.intp)


def _spread(first: NDArray[np.intp]) -> NDArray[np.intp]:
    """A selection of at most MAX_WINDOWS windows, spread evenly."""
    return first[np.linspace(0, first.size - 1, min(first.size, MAX_WINDOWS)).astype(np.intp)]


def parts_in_turns(motion: WholeMotion) -> list[tuple[Windows, WholeMotion]]:
    """Windows of all but one part of the data, and that part."""
    edges = np.linspace(0, motion.velocity.shape[0], PARTS + 1).astype(int).tolist()
    found = []
    for a, b in pairwise(edges):
        inside = motion.between(a, b)
        first = _level(motion)
        rest = first[(first + WINDOW_CELLS < a) | (first >= b)]
        found.append((Windows(motion, _spread(rest), WINDOW_CELLS), inside))
    return found


@dataclass(frozen=True, slots=True)
class Judgement:
    """A model held against data that it was not fitted to.

    Attributes:
        errors: of its predictions.
        fitted: the model.
        test: the data.
    """

    errors: Errors
    fitted: Fit
    test: WholeMotion


def judged(windows: Windows, begin: Fit, scales: Scales, test: WholeMotion) -> Judgement:
    """The model fitted to the windows, held against `test`."""
    structure = begin.structure
    fitted = fit(windows, structure, begin.parameters, begin.scale, scales.bounds(structure))
    return Judgement(errors(structure, fitted.parameters, test), fitted, test)


def together(found: list[Judgement]) -> Errors:
    """Errors of several parts as of one."""
    if len(found) == 1:
        return found[0].errors
    weights = np.array([each.test.velocity.shape[0] for each in found], dtype=np.float64)

    def mean(values: list[Array]) -> Array:
        return np.asarray(np.sqrt(np.average(np.stack(values) ** 2, axis=0, weights=weights[: len(values)])))

    every = [each.errors for each in found]
    shared = [seconds for seconds in every[0].horizons if all(seconds in each.horizons for each in every)]
    horizons = {
        seconds: (
            mean([each.horizons[seconds][0] for each in every]),
            mean([each.horizons[seconds][1] for each in every]),
            mean([each.horizons[seconds][2] for each in every]),
        )
        for seconds in shared
    }
    track = {
        seconds: float(mean([np.array(each.track[seconds]) for each in every]))
        for seconds in shared
        if seconds in every[0].track
    }
    return Errors(
        every[0].axes, horizons, mean([each.free_run for each in every]), mean([each.zero for each in every]), track
    )
