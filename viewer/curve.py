"""The learned curve as lines on axes: where it was learned, where it continues, its tube, how sure it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.model import Model
from viewer.axes import Axes
from viewer.frame import Floats

Lines = Sequence[Floats] | Floats
"""Lines through (n, 2) points each, or (m, n, 2) for m lines of equal length."""
NONE: Floats = np.empty((0, 2, 2))
CURVE_STEP = 9.0  # canvas units between two points of the curve


def draw(model: Model, axes: Axes) -> dict[str, Lines]:
    """The learned curve over the whole axis, as strips in rad/s and N m."""
    low, high = model.trained_range or (0.0, 0.0)
    rate = np.unique(np.concatenate((np.arange(-axes.x, axes.x, axes.size(CURVE_STEP)[0]), (low, high))))
    said = model.predict(rate)
    curve = np.column_stack((rate, said.damping))
    tube = np.array([0.0, model.epsilon])
    # Over several velocities it is a slice, which may be steeper than all samples.
    inside = np.abs(said.damping) <= axes.y
    known, unknown = runs(curve, ~said.extrapolated & inside), runs(curve, said.extrapolated)
    broken = [dashes(run if run[0, 0] > 0.0 else run[::-1], axes.y) for run in unknown]
    return {
        "function": known,
        "tube": [run + side * tube for run in known for side in (-1.0, 1.0)],
        "uncertainty": _hatch(curve, 1.96 * said.sigma, axes),
        "extrapolation": np.concatenate(broken) if broken else NONE,
        "trained_range": np.concatenate([_dotted(at, axes) for at in (low, high)]),
    }


def runs(curve: Floats, chosen: NDArray[np.bool_]) -> list[Floats]:
    """The parts of the (n, 2) curve where `chosen` (n,) holds, each at least two points long."""
    ends = np.flatnonzero(np.diff(chosen)) + 1
    parts = zip(np.split(curve, ends), np.split(chosen, ends), strict=True)
    return [part for part, wanted in parts if wanted[0] and len(part) > 1]


def _hatch(curve: Floats, doubt: Floats, axes: Axes) -> list[Floats]:
    """The area within ±doubt (n,) [N m] of the curve (n, 2), on the axes: its two edges and strokes between them."""
    if not np.isfinite(doubt).all():
        return []
    rate, damping = curve.T
    below, above = (np.column_stack((rate, np.clip(damping + side * doubt, -axes.y, axes.y))) for side in (-1.0, 1.0))
    # One line runs through all strokes: up the first, along the edge, down the second, along the other edge, and on.
    strokes = np.stack((below, above), axis=1)
    strokes[1::2] = strokes[1::2, ::-1]
    return [below, above, strokes.reshape(-1, 2)]


def dashes(curve: Floats, reach: float) -> Floats:
    """The part of the (n, 2) curve within ±reach, with gaps: two steps of line, two of nothing; (m, 3, 2)."""
    drawn = curve[1:][np.abs(curve[1:, 1]) <= reach]
    whole = len(drawn) // 4
    return drawn[: 4 * whole].reshape(whole, 4, 2)[:, :3]


def _dotted(at: float, axes: Axes) -> Floats:
    """A dotted upright line at this rate, as (n, 2, 2) strips."""
    dot = axes.size(7.0)[1]
    y = np.arange(-axes.y, axes.y, 2.5 * dot)
    dots = np.full((y.size, 2, 2), at)
    dots[:, 0, 1], dots[:, 1, 1] = y, y + dot
    return dots
