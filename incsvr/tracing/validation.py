"""Predictions on data that was not used for the fit: of the torque, of free runs, and some time scales ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from incsvr.model_trace.held_out import Ahead, Errors, horizons, joined_errors, trivial
from incsvr.model_trace.statistics import change_of_rms, rms
from incsvr.model_trace.thresholds import (
    HORIZON_SCALES,
    INDEPENDENT_BLOCK_SCALES,
    MAX_HELD_OUT_PIECES,
    MIN_PIECE_SCALES,
    MIN_RUNS,
    TORQUE_BLOCK_SCALES,
)
from incsvr.numerics import Array
from incsvr.tracing.candidates import residual
from incsvr.tracing.cells import Cells
from incsvr.tracing.dynamics import Dynamics, Windows
from incsvr.tracing.errors import Problem, motion_model, pieces_of
from incsvr.tracing.fit import Fit, fit
from incsvr.tracing.hypothesis import Hypothesis


@dataclass(frozen=True, slots=True)
class Validation:
    """Errors of the declared model and of the one with the effects, on the same unseen data.

    Attributes:
        before, after: piece by piece.
        on: "recordings", or "blocks" of the fitted ones.
        step: between two stamps of a free run [s].
        scale: T_c [s].
    """

    before: Errors
    after: Errors
    on: str
    step: float
    scale: float

    def to_dict(self, floor: float) -> dict[str, Any]:
        """The contract's `error`; `floor` is the torque's error on the fitted data [N m]."""
        blocks = max(round(INDEPENDENT_BLOCK_SCALES / TORQUE_BLOCK_SCALES), 4)
        torque = change_of_rms(self.before.torque, self.after.torque, blocks)
        length = max(round(INDEPENDENT_BLOCK_SCALES * self.scale / self.step), 4)
        free = change_of_rms(self.before.free_run, self.after.free_run, length)
        return {
            "before": self.before.to_dict(),
            "after": self.after.to_dict(),
            "change": {"torque_rmse": torque.to_dict(), "free_run_rmse": free.to_dict()},
            "floor": {"torque_rmse": floor},
            "trivial": trivial(self.after.measured),
            "horizons": horizons(self.before.ahead, self.after.ahead),
            "validated_on": self.on,
        }


def validate(problem: Problem, nothing: Fit, best: Fit, other: Cells | None) -> Validation:
    """The errors of both fits on unseen cells; without such, on halves of pieces that take turns.

    Args:
        other: recordings that were not fitted.
    """
    cells = problem.cells if other is None else other
    if other is not None:
        pairs = [(nothing.hypothesis, best.hypothesis, pieces_of(other))]
    else:
        halves, pairs = _halves(problem.cells), []
        for fitted_on, held_out in (halves, halves[::-1]):
            bare = _fitted_on(problem, nothing, fitted_on)
            full = _fitted_on(problem, best, fitted_on) if best.hypothesis.parts else bare
            pairs.append((bare, full, held_out))
    found = [[errors(cells, each, slices, problem.cells) for each in both] for *both, slices in pairs]
    before, after = (joined_errors(each) for each in zip(*found, strict=True))
    return Validation(before, after, "blocks" if other is None else "recordings", cells.step, cells.signals.scale)


def free_runs(problem: Problem, fitted: Fit) -> Array:
    """(pieces,) root mean square error [rad/s] of free runs over pieces that a fit did not see.

    Whole recordings are left out where there are as many as the search asks, else halves of pieces take turns.
    """
    number = problem.cells.run
    if np.unique(number).size >= MIN_RUNS:
        runs = list(zip(pieces_of(problem.cells), number.tolist(), strict=True))
        turns = [
            ([piece for piece, run in runs if run != k], [piece for piece, run in runs if run == k])
            for k in np.unique(number)
        ]
    else:
        halves = _halves(problem.cells)
        turns = [halves, halves[::-1]]
    found = list[float]()
    for fitted_on, held_out in turns:
        model = motion_model(problem.cells, _fitted_on(problem, fitted, fitted_on))
        course = Dynamics(problem.cells, model).simulate(Windows.of(held_out)).rate
        for k, piece in enumerate(held_out):
            found.append(rms([course[1 : piece.stop - piece.start + 1, k] - problem.cells.end[piece]]))
    return np.array(found)


def errors(cells: Cells, hypothesis: Hypothesis, slices: Sequence[slice], fitted: Cells) -> Errors:
    """Errors of a hypothesis over slices of cells; `fitted` are the cells to whose clock its drifts refer."""
    origin = fitted.signals.origin
    cells = replace(cells, signals=replace(cells.signals, origin=origin), fine=replace(cells.fine, origin=origin))
    model = motion_model(fitted, hypothesis)
    dynamics = Dynamics(cells, model)
    s, whole = cells.signals, Windows.of(slices)
    course = dynamics.simulate(whole)
    time = [np.append(s.time[each], s.time[each.stop - 1] + s.step) for each in slices]
    measured = [np.append(s.rate[each], cells.end[each.stop - 1]) for each in slices]
    simulated = [course.rate[: each.stop - each.start + 1, k] for k, each in enumerate(slices)]
    left = residual(dynamics)
    size = block_size(cells)
    torque = [block_means(left[each], size) for each in slices]
    ahead = [_ahead(dynamics, slices, horizon * s.scale) for horizon in HORIZON_SCALES]
    return Errors(tuple(time), tuple(measured), tuple(simulated), tuple(torque), tuple(ahead))


def block_size(cells: Cells) -> int:
    """Cells in a block of the torque's error."""
    return max(round(TORQUE_BLOCK_SCALES * cells.signals.scale / cells.step), 1)


def block_means(values: Array, size: int) -> Array:
    """Means of (n,) values over blocks of so many; what is left at the end is in none."""
    count = values.size // size
    return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))


def _ahead(dynamics: Dynamics, slices: Sequence[slice], horizon: float) -> Ahead:
    """Predictions over `horizon` [s] from measured rates, side by side."""
    cells = dynamics.cells
    windows = Windows.tiled(slices, max(round(horizon / cells.step), 1))
    if not windows.first.size:
        return Ahead(*(np.empty(0) for _ in range(3)))
    simulated = dynamics.simulate(windows).rate[-1]
    first, last = cells.signals.rate[windows.first], cells.end[windows.first + windows.steps - 1]
    return Ahead(simulated - last, last - first, last)


def _fitted_on(problem: Problem, fitted: Fit, slices: Sequence[slice]) -> Hypothesis:
    """The hypothesis, fitted to some slices alone."""
    inside = np.zeros(len(problem.cells), dtype=bool)
    for each in slices:
        inside[each] = True
    windows = problem.windows
    use = inside[windows.first] & inside[windows.first + windows.steps - 1]
    return fit(problem, fitted.hypothesis, fitted.colour, use=use).hypothesis


def _halves(cells: Cells) -> tuple[list[slice], list[slice]]:
    """Pieces of the cells, taken in turns."""
    slices = []
    for piece in pieces_of(cells):
        longest = (piece.stop - piece.start) * cells.step / (MIN_PIECE_SCALES * cells.signals.scale)
        count = min(max(int(longest), 1), MAX_HELD_OUT_PIECES)
        slices += [
            slice(a, b) for a, b in pairwise(np.linspace(piece.start, piece.stop, count + 1).astype(int).tolist())
        ]
    if len(slices) == 1:
        (only,) = slices
        middle = (only.start + only.stop) // 2
        slices = [slice(only.start, middle), slice(middle, only.stop)]
    return slices[::2], slices[1::2]
