"""Proof on data that was not used for the fit: torque error and free-run error of a hypothesis, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from incsvr.effects import Signals, Term
from incsvr.evidence import rms
from incsvr.tracer.comparison import gained, likelier
from incsvr.tracer.forward import STEPS, model_of
from incsvr.tracer.hypothesis import Hypothesis, left_over, nothing, settle
from incsvr.tracer.posing import pose_like
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array, Run

FOLDS = 5
"""Held-out folds where no validation recordings are given."""

FEW = 20
"""Fewer pieces than that are held out one by one."""

LOST = 1.0
"""By how many standard errors the free run may be worse as it is where its errors are likelier."""

QUICK_FOLDS = 3
"""The same while a search asks: it compares, and the inner parameters stay those of all blocks."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors on unseen data, piece by piece.

    Attributes:
        time: stamps of the free run [s].
        measured: yaw rate there [rad/s].
        simulated: free run of the hypothesis [rad/s].
        free_run: simulated − measured.
        block_time: stamps of the block residuals [s].
        block_rate: mean yaw rate of each block [rad/s].
        block_error: mean free-run error of each block [rad/s].
        mistimed: of each block, as `Blocks` has it.
        torque: (n_b,) block residuals [N m].
    """

    time: tuple[Array, ...]
    measured: tuple[Array, ...]
    simulated: tuple[Array, ...]
    free_run: tuple[Array, ...]
    block_time: tuple[Array, ...]
    block_rate: tuple[Array, ...]
    block_error: tuple[Array, ...]
    mistimed: tuple[Array, ...]
    torque: tuple[Array, ...]

    def free_run_rmse(self) -> float:
        """[rad/s]."""
        return rms(self.free_run)


@dataclass(frozen=True, slots=True)
class Court:
    """Where hypotheses are proven: validation recordings, or held-out pieces of the fitted ones.

    Attributes:
        problem: the fitted recordings.
        validation: the validation recordings, posed alike; None for held-out pieces.
        pieces: blocks of each held-out piece.
        weighs: whether free runs may be compared by the likelihood of their errors, too.
        quick: whether a search asks.
        known: errors of the hypotheses tried so far: a search asks for some of them again.
    """

    problem: Problem
    validation: Problem | None
    pieces: tuple[slice, ...]
    weighs: bool
    quick: bool = False
    known: dict[tuple[Term, ...], Errors] = field(default_factory=dict, compare=False, repr=False)

    @staticmethod
    def of(problem: Problem, validate: Sequence[Run] | None, *, quick: bool = False) -> Court:
        """Held-out pieces are about a twentieth of the recordings and at least four time scales long."""
        blocks = problem.blocks
        length = max(len(blocks) / 20.0, 4.0 * problem.signals.scale / blocks.period)
        length = min(length, len(blocks) / 4.0)
        pieces = []
        for a, b in zip(blocks.start[:-1], blocks.start[1:], strict=True):
            edges = np.linspace(a, b, max(round((b - a) / length), 1) + 1).astype(int)
            pieces += [slice(int(p), int(q)) for p, q in pairwise(edges) if q - p > 3]
        others = _posed(problem, validate) if validate else None
        weighs = not problem.closed_loop
        return Court(problem, others, tuple(pieces), weighs, quick)

    @property
    def validated_on(self) -> str:
        return "blocks" if self.validation is None else "recordings"

    def __call__(self, hypothesis: Hypothesis) -> float:
        """Free-run error of a hypothesis on unseen data [rad/s]."""
        return self.errors(hypothesis).free_run_rmse()

    def better(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether the free run of `new` beats that of `old` by more than chance would have it.

        Its error is the noise of the water, summed up by the vehicle; what an effect changes may be small beside that
        and yet certain. So the two are compared as they are, and by the likelihood of what the noise makes of a free
        run. But a torque that answers the noise carries it into the free run.
        """
        before, after = self.errors(old), self.errors(new)
        plain = np.array([float(o @ o - n @ n) for o, n in zip(before.free_run, after.free_run, strict=True)])
        if gained(plain) or not self.weighs:
            return gained(plain)
        lost = plain.mean() < -LOST * plain.std() / np.sqrt(plain.size)
        period = self.problem.blocks.period
        return not lost and gained(likelier(before.block_error, after.block_error, after.mistimed, period))

    def errors(self, hypothesis: Hypothesis) -> Errors:
        """Errors of a hypothesis on unseen data; those it was asked for before are known."""
        if hypothesis.terms not in self.known:
            self.known[hypothesis.terms] = self.try_(hypothesis)
        return self.known[hypothesis.terms]

    def try_(self, hypothesis: Hypothesis) -> Errors:
        """Errors of a hypothesis; on held-out pieces after a refit without them."""
        if self.validation is not None:
            runs = self.validation.blocks
            spans = [slice(int(a), int(b)) for a, b in zip(runs.start[:-1], runs.start[1:], strict=True)]
            return _errors(self.problem, self.validation, hypothesis, spans)
        folds = QUICK_FOLDS if self.quick else FOLDS
        if len(self.pieces) < FEW:  # a third of so short recordings may be all that there was of some rate
            folds = len(self.pieces)
        parts = []
        for fold in range(folds):
            held = self.pieces[fold::folds]
            used = np.ones(len(self.problem.blocks), dtype=bool)
            for piece in held:
                used[piece] = False
            less = replace(self.problem, blocks=self.problem.blocks.only(used))
            parts.append(_errors(less, self.problem, refit(less, hypothesis, refine=not self.quick), held))
        return Errors(*(tuple(x for part in parts for x in getattr(part, name)) for name in Errors.__slots__))


def refit(problem: Problem, hypothesis: Hypothesis, *, refine: bool = True) -> Hypothesis:
    """The same effects fitted to other blocks."""
    if not hypothesis.terms:
        return nothing(problem)
    terms = hypothesis.values()
    # an instant or a period on the recording's clock stays: no other piece of the recording can tell it
    refined = frozenset(e.key for e in hypothesis.effects if refine and not e.needs_clock)
    return settle(problem, terms, hypothesis, refined, passes=3)


def _errors(fitted: Problem, problem: Problem, hypothesis: Hypothesis, spans: Sequence[slice]) -> Errors:
    residual = torque_errors(fitted, problem, hypothesis)
    blocks = problem.blocks
    size = blocks.size
    slices = [slice(int(blocks.first[p.start]), int(blocks.first[p.stop - 1]) + size + 1) for p in spans]
    signals = problem.signals.pieces(slices)
    step = min(signals.scale / STEPS, blocks.period)
    index, simulated = model_of(fitted, hypothesis).simulate(_driving(problem), step, slices)
    run = np.searchsorted(signals.start, index, side="right") - 1
    groups = [np.flatnonzero(run == k) for k in range(len(slices))]
    measured = signals.rate[index]
    error = simulated - measured
    mean_error = [
        _averaged(error[g], (index[g] - signals.start[k]) // size, p.stop - p.start)
        for k, (g, p) in enumerate(zip(groups, spans, strict=True))
    ]
    mean_rate = blocks.mean(problem.signals.rate)
    middle = problem.signals.time[blocks.first + size // 2]
    return Errors(
        time=tuple(signals.time[index[g]] for g in groups),
        measured=tuple(measured[g] for g in groups),
        simulated=tuple(simulated[g] for g in groups),
        free_run=tuple(error[g] for g in groups),
        block_time=tuple(middle[p] for p in spans),
        block_rate=tuple(mean_rate[p] for p in spans),
        block_error=tuple(mean_error),
        mistimed=tuple(blocks.mistimed[p] for p in spans),
        torque=tuple(residual[p] for p in spans),
    )


def _averaged(values: Array, block: NDArray[np.intp], count: int) -> Array:
    """(count,) mean of the values in each block; what lies at the end of the last is in none."""
    inside = block < count
    total = np.bincount(block[inside], weights=values[inside], minlength=count)
    mean: Array = total / np.bincount(block[inside], minlength=count)
    return mean


def _posed(problem: Problem, runs: Sequence[Run]) -> Problem:
    """The validation recordings, posed alike; whether their command is known they must say themselves."""
    others = pose_like(problem, runs)
    known = others.signals.known and others.knows_command(left_over(others, nothing(problem))[0])
    return replace(others, signals=replace(others.signals, known=known))


def _driving(problem: Problem) -> Signals:
    """What drives a free run: the torque, or the command where it is known what of the torque is but noise."""
    s, plain = problem.signals, problem.command.plain
    return replace(s, torque=plain) if s.known and plain is not None else s


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
