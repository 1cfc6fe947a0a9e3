"""Free runs of a learned damping together with traced effects, against measured runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from incsvr.compensation.effects_in_force import Compensation
from incsvr.model.rows import Factor, Part, Row
from incsvr.model.series import effort_of
from incsvr.model.simulation import simulate
from incsvr.model.structure import Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array, Stream, Streams
from incsvr.signals import TORQUE, YAW_RATE


def traced_free_run_errors(
    pieces: Sequence[Streams],
    compensation: Compensation,
    damping: Callable[[Array], Array],
    steps: float = 40.0,  # in the vehicle's time scale
    cells: int = 200,  # of the damping's table to either side
) -> list[Array]:
    """(m,) simulated minus measured yaw rate of each piece [rad/s], from its first measured yaw rate with torque and
    channels.

    Args:
        pieces: without a pause, name → (stamps [s], values).
        compensation: the effects.
        damping: the learned d(r), (n,) rad/s → (n,) N m.
    """
    if not pieces:
        return []
    model, axis = compensation.model, compensation.model.axis
    width = 2.0 * max(1e-3, *(float(np.abs(piece[YAW_RATE][1]).max()) for piece in pieces)) / cells
    table = damping(np.asarray(width * np.arange(-cells, cells + 1)))
    own = Row("learned", (Part(axis, Factor("curve", axis, width, tuple(table.tolist()))),))
    names = {name: stream for name, stream in compensation.streams.items() if stream != YAW_RATE}
    given = {axis: math.log(model.inertia)}
    structure = model.added_to(Structure((axis,), (axis,), (own,), given=given, channels=tuple(names)))
    theta, runs = {own.key: 1.0, **model.theta}, []
    for piece in pieces:
        begin, end = piece[YAW_RATE][0][[0, -1]].tolist()
        series = {axis: piece[YAW_RATE], effort_of(axis): model.acting(piece[TORQUE])}
        series |= {name: piece[stream] for name, stream in names.items()}
        runs.append({name: _over(stream, begin, end + model.scale) for name, stream in series.items()})
    windows = cut(runs, structure, model.scale / steps, np.inf)
    course = simulate(structure, np.array([theta[name] for name in structure.names]), windows, windows.starts)
    found = []
    for k, (piece, grid) in enumerate(zip(pieces, windows.grids, strict=True)):
        time, measured = piece[YAW_RATE]
        found.append(np.interp(time, windows.edges(grid), course.states[: grid.steps + 1, 0, k]) - measured)
    return found


def _over(stream: Stream, begin: float, end: float) -> Stream:
    """A stream that reaches over a span [s]; before and after its values it is constant."""
    time, value = stream
    before, after = time[:1] > begin, time[-1:] < end
    return (
        np.concatenate((np.full(before.sum(), begin), time, np.full(after.sum(), end))),
        np.concatenate((value[:1][before], value, value[-1:][after])),
    )
