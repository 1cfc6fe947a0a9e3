"""Errors of a vehicle's model on unseen data: other recordings, or each part of these by the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.vehicle.fitting import Fit, Windows, fit
from incsvr.vehicle.motion import CELLS_A_SCALE, WholeMotion
from incsvr.vehicle.scales import Scales
from incsvr.vehicle.structure import Structure
from incsvr.vehicle.validation import NO_ERRORS, Course, Errors, alone, errors, longest_course

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


@dataclass(frozen=True, slots=True)
class Validation:
    """The errors of an identified model on unseen data.

    Attributes:
        errors: of all axes together.
        by_itself: axis → those of that axis alone, the other velocities as measured.
        course: a free run on the unseen data, or on its last part; None where there are none.
    """

    errors: Errors
    by_itself: Mapping[str, Errors]
    course: Course | None


NO_VALIDATION = Validation(NO_ERRORS, {}, None)
"""The validation of a model that was not asked to predict: no errors, no course."""


def validated(
    windows: Windows, unseen: WholeMotion | None, fitted: Fit, scales: Scales, begins: Callable[[str], None]
) -> Validation:
    """The errors of a model on other recordings, or on each part of its own by the others.

    Args:
        windows: of the recordings that the model was fitted to.
        unseen: other recordings.
        begins: callback that is given each step as it begins.
    """
    motion = windows.motion
    splits = [(windows, unseen)] if unseen is not None else _parts_in_turns(motion)
    begins("predicting unseen data")
    judgements = [_judged(part, fitted, scales, test) for part, test in splits]
    by_itself = {}
    for axis in motion.axes:
        begins(f"predicting {axis} by itself")
        begin = _alone(fitted, axis, motion, scales)
        by_itself[axis] = _together([_judged(part, begin, scales, test) for part, test in splits])
    last = judgements[-1]
    course = longest_course(last.fitted.structure, last.fitted.parameters, last.test)
    return Validation(_together(judgements), by_itself, course)


def _parts_in_turns(motion: WholeMotion) -> list[tuple[Windows, WholeMotion]]:
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
class _Judgement:
    """A model held against data that it was not fitted to.

    Attributes:
        errors: of its predictions.
        fitted: the model.
        test: the data.
    """

    errors: Errors
    fitted: Fit
    test: WholeMotion


def _judged(windows: Windows, begin: Fit, scales: Scales, test: WholeMotion) -> _Judgement:
    """The model fitted to the windows, held against `test`."""
    structure = begin.structure
    fitted = fit(windows, structure, begin.parameters, begin.scale, scales.bounds(structure))
    return _Judgement(errors(structure, fitted.parameters, test), fitted, test)


def _together(found: list[_Judgement]) -> Errors:
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


def _alone(fitted: Fit, axis: str, motion: WholeMotion, scales: Scales) -> Fit:
    """The start of the fit of one axis by itself: at the whole model's parameters, with no further product."""
    own = alone(fitted.structure, axis, motion.recorded)
    kept = [k for k in range(fitted.structure.size) if _belongs(fitted.structure, k, axis)]
    values = dict(zip(_names(fitted.structure), fitted.parameters.tolist(), strict=True))
    scale = dict(zip(_names(own), scales.start(own)[1].tolist(), strict=True))
    scale |= {_names(fitted.structure)[k]: float(fitted.scale[k]) for k in kept}
    names = _names(own)
    begin = np.array([values.get(name, 0.0) for name in names])
    return Fit(own, begin, np.array([scale[name] for name in names]), *(np.empty(0),) * 4)


def _names(structure: Structure) -> list[object]:
    """The term and axis of each parameter."""
    return [*structure.mass, *structure.terms, *structure.lags]


def _belongs(structure: Structure, place: int, axis: str) -> bool:
    """Whether a parameter is one of an axis by itself."""
    masses, terms = len(structure.mass), len(structure.terms)
    if place < masses:
        return structure.mass[place] == (axis, axis)
    if place < masses + terms:
        return structure.terms[place - masses].axis == axis
    return structure.lags[place - masses - terms] == axis
