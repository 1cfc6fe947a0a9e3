"""Predictions on data that was not used for the fit: of the equation in blocks, and of free runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from incsvr.tracing.forward.equations import columns, predicted, target, thrust
from incsvr.tracing.forward.fit import Fit, fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.held_out import Errors
from incsvr.tracing.model import STEPS, TracedModel
from incsvr.tracing.skill import ahead, horizons, joined, trivial
from incsvr.tracing.statistics import change_of_rms, rms

Array = NDArray[np.float64]

PIECES, SHORTEST = 8, 20.0
"""Pieces of a recording that are held out in turns at most, and how many time scales long each is at least."""

BLOCK = 0.25
"""Time scales in a block of the equation's error: within one the gyro's noise would be most of it."""


@dataclass(frozen=True, slots=True)
class Validation:
    """Errors of the declared model and of the one with the effects, on the same unseen data.

    Attributes:
        before, after: piece by piece.
        on: "recordings", or "blocks" of the fitted ones.
        scale: T_c [s].
    """

    before: Errors
    after: Errors
    on: str
    scale: float

    def to_dict(self, floor: float) -> dict[str, Any]:
        """The contract's `error`; `floor` is the equation's error on the fitted data [N m]."""
        torque = change_of_rms(self.before.torque, self.after.torque, max(round(4.0 / BLOCK), 4))
        step = float(np.median(np.concatenate([np.diff(t) for t in self.before.time if t.size > 1])))
        free = change_of_rms(self.before.free_run, self.after.free_run, max(round(4.0 * self.scale / step), 4))

        def of(errors: Errors) -> dict[str, float]:
            flat = np.concatenate(errors.torque)
            mae, rmse = float(np.mean(np.abs(flat))), float(np.sqrt(np.mean(flat**2)))
            return {"torque_mae": mae, "torque_rmse": rmse, "free_run_rmse": rms(errors.free_run)}

        return {
            "before": of(self.before),
            "after": of(self.after),
            "change": {"torque_rmse": torque.to_dict(), "free_run_rmse": free.to_dict()},
            "floor": {"torque_rmse": floor},
            "trivial": trivial(self.after.measured),
            "horizons": horizons(self.before.ahead, self.after.ahead),
            "validated_on": self.on,
        }


def validate(grid: Grid, complete: Fit, base: Fit, validation_grid: Grid | None) -> Validation:
    """The errors of `base` and `complete` on unseen recordings; without them, on halves of pieces that take turns.

    Args:
        grid: the fitted recordings.
        complete, base: the fits with effects and without.
        validation_grid: recordings that were not fitted.
    """
    scale = grid.signals.scale
    if validation_grid is not None:
        errors = [_errors(validation_grid, model_of(grid, each), each) for each in (base, complete)]
        return Validation(errors[0], errors[1], "recordings", scale)
    halves = _halves(grid)
    parts = []
    for fitted_on, held_out in (halves, halves[::-1]):
        there, here = grid.pieces(fitted_on), grid.pieces(held_out)
        nothing = fit(there, (), base)
        with_effects = fit(there, complete.parts, complete) if complete.parts else nothing
        parts.append([_errors(here, model_of(there, each), each) for each in (nothing, with_effects)])
    before, after = (_joined(pair) for pair in zip(*parts, strict=True))
    return Validation(before, after, "blocks", scale)


def model_of(grid: Grid, fitted: Fit) -> TracedModel:
    """A fitted hypothesis as a model: its damping passive and never less for a faster turn, as a free run needs it."""
    s = grid.signals
    low, high = (float(q) for q in np.quantile(s.rate, [0.002, 0.998]))
    low, high = min(low, -1e-6), max(high, 1e-6)
    rate = np.unique(np.concatenate([np.linspace(low, 0.0, 101), np.linspace(0.0, high, 101)]))
    damping = fitted.model.damping_at(rate)
    often = np.histogram(s.rate, np.concatenate([[-np.inf], 0.5 * (rate[1:] + rate[:-1]), [np.inf]]))[0] + 0.1
    for side in (rate > 0.0, rate < 0.0):
        damping[side] = isotonic_regression(damping[side], weights=often[side]).x
    damping = np.sign(rate) * np.maximum(np.sign(rate) * damping, 0.0)
    block = max(BLOCK * s.scale, grid.cell)
    sigma = float(np.std(np.concatenate(block_means(grid, residual(grid, fitted))[0])))
    terms = tuple(part.term for part in fitted.parts)
    return TracedModel(s.inertia, rate, damping, terms, sigma, block, s.scale, s.origin)


def residual(grid: Grid, fitted: Fit) -> Array:
    """(n,) what the model leaves of the torque in each cell of any recording [N m]."""
    model = replace(fitted.model, loss=np.zeros(len(grid.signals)))
    first = predicted(grid, model).signals
    moments = [p for p in fitted.parts if not p.thrust and p.effect.acts != "inertia"]
    loss = np.sum([np.array(p.term.coefficients) @ columns(p, first) for p in moments], axis=0)
    seen = predicted(grid, replace(model, loss=loss) if moments else model)
    left = target(grid, thrust(grid.signals, fitted.parts))
    left = left - np.mean([fitted.model.damping_at(rate) for rate in seen.path], axis=0)
    for part in fitted.parts:
        if not part.thrust:
            left = left - np.array(part.term.coefficients) @ columns(part, seen.signals)
    return np.asarray(left)


def _halves(grid: Grid) -> tuple[list[slice], list[slice]]:
    """Pieces of the grid, taken in turns."""
    slices = []
    for begin, end in pairwise(grid.starts.tolist()):
        longest = (end - begin) * grid.cell / (SHORTEST * grid.signals.scale)
        count = min(max(int(longest), 1), PIECES)
        slices += [slice(a, b) for a, b in pairwise(np.linspace(begin, end, count + 1).astype(int).tolist())]
    if len(slices) == 1:
        only = slices[0]
        middle = (only.start + only.stop) // 2
        slices = [slice(only.start, middle), slice(middle, only.stop)]
    return slices[::2], slices[1::2]


def block_means(grid: Grid, values: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Means of (n,) values over blocks, piece by piece, and the blocks' stamps."""
    size = max(round(BLOCK * grid.signals.scale / grid.cell), 1)
    means, times = [], []
    for begin, end in pairwise(grid.starts.tolist()):
        count = (end - begin) // size
        part = slice(begin, begin + count * size)
        means.append(values[part].reshape(count, size).mean(axis=1))
        times.append(grid.signals.time[part].reshape(count, size)[:, size // 2])
    return tuple(means), tuple(times)


def _errors(grid: Grid, model: TracedModel, fitted: Fit) -> Errors:
    torque, block_time = block_means(grid, residual(grid, fitted))
    s = replace(grid.signals, origin=model.origin)
    index, simulated = model.simulate(s)
    piece = np.searchsorted(s.start, index, side="right") - 1
    groups = [np.flatnonzero(piece == k) for k in range(s.start.size - 1)]
    time = tuple(s.time[index[g]] for g in groups)
    measured, free = tuple(s.rate[index[g]] for g in groups), tuple(simulated[g] for g in groups)
    error = tuple(simulated_rate - rate for simulated_rate, rate in zip(free, measured, strict=True))
    slope = tuple(np.gradient(values, grid.cell) if values.size > 1 else np.zeros(values.size) for values in free)
    steps = ahead([model], s, model.scale / STEPS, [s.runs()], model.scale)
    return Errors(time, measured, free, error, slope, block_time, (), (), (), (), torque, steps)


def _joined(parts: Sequence[Errors]) -> Errors:
    """The errors of several held-out sets as one."""
    pieces = [field.name for field in fields(Errors) if field.name != "ahead"]
    together = {name: tuple(piece for part in parts for piece in getattr(part, name)) for name in pieces}
    return Errors(**together, ahead=joined([part.ahead for part in parts]))
