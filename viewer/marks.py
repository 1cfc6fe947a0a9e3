"""How each set of samples looks: a shape beside the colour, in physical units, so that pointing gives rad/s and N m.

Every set is `Points2D`, whatever is drawn around the points. A set that is empty in this iteration is logged empty, or
the last one would stay on the screen.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
from rerun.components import Radius

from viewer.axes import Axes
from viewer.component_batches import ComponentBatches, boxes, points, strips
from viewer.frame import Floats
from viewer.painter import Mark
from viewer.palette import Colour

_CORE: dict[Mark, float] = {
    "disc": 4.5,
    "halo": 9.5,
    "square": 3.5,
    "dash": 1.3,
    "bar": 1.3,
    "cross": 2.0,
    "diamond": 2.0,
}
_BOXES: dict[Mark, tuple[float, float]] = {"square": (4.5, 4.5), "dash": (10.0, 0.6), "bar": (0.6, 10.0)}
_STROKE: dict[Mark, float] = {"square": 2.4, "dash": 1.4, "bar": 1.4, "cross": 2.0, "diamond": 1.8}


def style(mark: Mark, colour: Colour, *, order: float) -> list[rr.AsComponents]:
    """What stays the same over all iterations; logged once, static."""
    stroke = None if mark not in _STROKE else Radius.ui_points(_STROKE[mark])
    parts: list[rr.AsComponents] = [
        rr.Points2D.from_fields(colors=colour, radii=Radius.ui_points(_CORE[mark]), draw_order=order)
    ]
    if mark in _BOXES:
        parts.append(rr.Boxes2D.from_fields(colors=colour, radii=stroke, draw_order=order))
    elif mark in ("cross", "diamond"):
        parts.append(rr.LineStrips2D.from_fields(colors=colour, radii=stroke, draw_order=order))
    return parts


def shape(mark: Mark, at: Floats, axes: Axes) -> list[ComponentBatches]:
    """The samples `at` (n, 2) [rad/s, N m] as this mark, upright on `axes`."""
    if mark in _BOXES:
        across, up = axes.size(1.0)
        return [points(at), boxes(at, (across * _BOXES[mark][0], up * _BOXES[mark][1]))]
    if mark in ("cross", "diamond"):
        dx, dy = axes.size(10.0 if mark == "cross" else 14.0)
        strokes = (
            [[[-dx, -dy], [dx, dy]], [[-dx, dy], [dx, -dy]]]
            if mark == "cross"
            else [[[0.0, dy], [dx, 0.0], [0.0, -dy], [-dx, 0.0], [0.0, dy]]]
        )
        corners = np.array(strokes)
        return [points(at), strips((at[:, None, None, :] + corners[None]).reshape(-1, corners.shape[1], 2))]
    return [points(at)]
