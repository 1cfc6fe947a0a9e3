"""Errors of a hypothesis on blocks that it was not fitted to: of the torque, and of free runs, piece by piece."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from incsvr.effects import Signals
from incsvr.tracing.held_out import Errors
from incsvr.tracing.model import STEPS, simulate
from incsvr.tracing.run import Array
from incsvr.tracing.skill import ahead
from incsvr.tracing.weak.hypothesis import Hypothesis, left_over
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.problem import Problem


def errors_on(
    problem: Problem, fits: Sequence[tuple[Problem, Hypothesis, Sequence[slice]]], *, torque: bool = True
) -> Errors:
    """Errors of hypotheses, each with the problem that it was fitted to, on these spans of blocks of another (or the
    same); side by side, piece after piece."""
    blocks = problem.blocks
    size = blocks.size
    spans = [span for *_, each in fits for span in each]
    torque_fits = fits if torque else ()
    residual = [torque_errors(fitted, problem, found)[span] for fitted, found, each in torque_fits for span in each]
    slices = [
        [slice(int(blocks.first[p.start]), int(blocks.first[p.stop - 1]) + size + 1) for p in each] for *_, each in fits
    ]
    signals = problem.signals.pieces([piece for each in slices for piece in each])
    step = min(signals.scale / STEPS, blocks.period)
    models = [model_of(fitted, found) for fitted, found, _ in fits]
    driving = _driving(problem)
    index, simulated = simulate(models, driving, step, slices)
    run = np.searchsorted(signals.start, index, side="right") - 1
    groups = [np.flatnonzero(run == k) for k in range(len(spans))]
    measured = signals.rate[index]
    error = simulated - measured
    slope = [np.gradient(simulated[g], signals.time[index[g]]) for g in groups]
    block = [(index[g] - signals.start[k]) // size for k, g in enumerate(groups)]
    counts = [p.stop - p.start for p in spans]
    mean_rate = blocks.mean(problem.signals.rate)
    middle = problem.signals.time[blocks.first + size // 2]
    return Errors(
        time=tuple(signals.time[index[g]] for g in groups),
        measured=tuple(measured[g] for g in groups),
        simulated=tuple(simulated[g] for g in groups),
        free_run=tuple(error[g] for g in groups),
        slope=tuple(slope),
        block_time=tuple(middle[p] for p in spans),
        block_rate=tuple(mean_rate[p] for p in spans),
        block_error=tuple(_averaged(error[g], *where) for g, *where in zip(groups, block, counts, strict=True)),
        block_slope=tuple(_averaged(values, *where) for values, *where in zip(slope, block, counts, strict=True)),
        mistimed=tuple(blocks.mistimed[p] for p in spans),
        torque=tuple(residual),
        ahead=ahead(models, driving, step, slices, signals.scale) if torque else (),
    )


def _averaged(values: Array, block: NDArray[np.intp], count: int) -> Array:
    """(count,) mean of the values in each block; what lies at the end of the last is in none."""
    inside = block < count
    total = np.bincount(block[inside], weights=values[inside], minlength=count)
    mean: Array = total / np.bincount(block[inside], minlength=count)
    return mean


def _driving(problem: Problem) -> Signals:
    """What drives a free run: the torque, or the command where it is known what of the torque is but noise."""
    s, levels = problem.signals, problem.command.levels
    return replace(s, torque=levels) if s.known and levels is not None else s


def torque_errors(fitted: Problem, problem: Problem, hypothesis: Hypothesis) -> Array:
    """(n_b,) block residuals of the model [N m]: with its damping table, which holds where the fit saw few rates."""
    residual, _ = left_over(problem, hypothesis)
    spline = problem.coarse @ hypothesis.fit.theta[: problem.coarse.shape[1]]
    table = problem.blocks.mean(model_of(fitted, hypothesis).damping_at(problem.signals.rate))
    return residual + spline - table


def sample_errors(torque: Sequence[Array], scatter: float) -> tuple[float, float]:
    """Mean absolute and root mean square torque error of single samples [N m].

    Args:
        torque: block residuals.
        scatter: deviation of the torque samples within a block that no motion of the vehicle follows.
    """
    e = np.concatenate([*torque])
    if scatter <= 0.0:
        return float(np.mean(np.abs(e))), float(np.sqrt(np.mean(e**2)))
    spread = scatter * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * (e / scatter) ** 2)
    mae = float(np.mean(spread + e * erf(e / (scatter * np.sqrt(2.0)))))
    return mae, float(np.sqrt(np.mean(e**2) + scatter**2))
