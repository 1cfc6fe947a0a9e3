"""Free runs of a learned damping together with traced effects, against measured runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from incsvr.compensation.effects_in_force import Compensation
from incsvr.model.rows import ONE, Factor, Part, Row, value
from incsvr.model.series import effort_of
from incsvr.model.simulation import simulate
from incsvr.model.structure import Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array, Stream, Streams
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.tracing.model import TracedModel


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
    names = {name: stream for name, stream in compensation.streams.items() if stream != YAW_RATE}
    structure, point = equation(axis, model.inertia, [learned_row(axis, width, table)], tuple(names), model)
    runs = []
    for piece in pieces:
        begin, end = piece[YAW_RATE][0][[0, -1]].tolist()
        series = {axis: piece[YAW_RATE], effort_of(axis): model.acting(piece[TORQUE])}
        series |= {name: piece[stream] for name, stream in names.items()}
        runs.append({name: _over(stream, begin, end + model.scale) for name, stream in series.items()})
    windows = cut(runs, structure, model.scale / steps, np.inf)
    course = simulate(structure, point, windows, windows.starts)
    found = []
    for k, (piece, grid) in enumerate(zip(pieces, windows.grids, strict=True)):
        time, measured = piece[YAW_RATE]
        found.append(np.interp(time, windows.edges(grid), course.states[: grid.steps + 1, 0, k]) - measured)
    return found


def equation(
    axis: str, inertia: float, learned: Sequence[Row], channels: Sequence[str], effects: TracedModel | None
) -> tuple[Structure, Array]:
    """The engine's motion of an axis, I ṙ + d(r) + Σ effects = τ, and the values of its parameters.

    Args:
        inertia: as it is declared [kg m²].
        learned: rows of the damping, and of what else is known, with coefficients of 1.
        channels: that are read as they were measured.
        effects: those of its effects that act on the samples of an effort have been applied (`TracedModel.acting`).
    """
    structure = Structure((axis,), (axis,), tuple(learned), given={axis: math.log(inertia)}, channels=tuple(channels))
    theta = {row.key: 1.0 for row in learned}
    if effects is not None:
        structure, theta = effects.added_to(structure), {**theta, **effects.theta}
    return structure, np.array([theta[name] for name in structure.names])


def learned_row(axis: str, width: float, curve: Array, scaled_by: str = "") -> Row:
    """A curve of an axis's own velocity by its values `width` apart, the middle one at rest, times a channel."""
    own = Factor("curve", axis, width, tuple(curve.tolist()))
    return Row(scaled_by or "learned", (Part(axis, own, value(scaled_by) if scaled_by else ONE),))


def _over(stream: Stream, begin: float, end: float) -> Stream:
    """A stream that reaches over a span [s]; before and after its values it is constant."""
    time, value = stream
    before, after = time[:1] > begin, time[-1:] < end
    return (
        np.concatenate((np.full(before.sum(), begin), time, np.full(after.sum(), end))),
        np.concatenate((value[:1][before], value, value[-1:][after])),
    )
