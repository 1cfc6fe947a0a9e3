"""Proof on data that was not used for the fit: torque error and free-run error of a hypothesis, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from incsvr.effects import Term
from incsvr.tracing.held_out import Errors
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.free_run_comparison import gained, likelier
from incsvr.tracing.weak.hypothesis import SAMPLING, Hypothesis, left_over, nothing, settle
from incsvr.tracing.weak.posing import pose_like
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.validation_errors import errors_on

FOLDS = 5
"""Held-out folds where no validation recordings are given."""

FEW = 20
"""Fewer pieces than that are held out one by one."""

LOST = 1.0
"""By how many standard errors the free run may be worse as it is where its errors are likelier."""

QUICK_FOLDS = 3
"""The same while a search asks: it compares, and the inner parameters stay those of all blocks."""


@dataclass(frozen=True, slots=True)
class Validation:
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
    def of(problem: Problem, validate: Sequence[Run] | None, *, quick: bool = False) -> Validation:
        """Held-out pieces are about a twentieth of the recordings and at least four time scales long."""
        blocks = problem.blocks
        length = max(len(blocks) / 20.0, 4.0 * problem.signals.scale / blocks.period)
        length = min(length, len(blocks) / 4.0)
        pieces = []
        for a, b in zip(blocks.start[:-1], blocks.start[1:], strict=True):
            edges = np.linspace(a, b, max(round((b - a) / length), 1) + 1).astype(int)
            pieces += [slice(int(p), int(q)) for p, q in pairwise(edges) if q - p > 3]
        others = _posed(problem, validate) if validate else None
        return Validation(problem, others, tuple(pieces), not problem.closed_loop, quick)

    @property
    def validated_on(self) -> str:
        return "blocks" if self.validation is None else "recordings"

    def __call__(self, hypothesis: Hypothesis) -> float:
        """Free-run error of a hypothesis on unseen data, put on time [rad/s]."""
        return self.on_time(hypothesis).free_run_rmse()

    def better(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether the free run of `new` beats that of `old` by more than chance would have it.

        As they are, or moved by what `old` is late: nobody knows when, between two samples, a command jumped or a clock
        was read, and of two hypotheses the right one may show it more. A slip of its own excuses no new one.
        """
        before, after = self.errors(old), self.errors(new)
        return any(self._gains(before.moved(by), after.moved(by)) for by in (0.0, self.late(old)))

    def late(self, hypothesis: Hypothesis) -> float:
        """By how much its free run comes late [s], as far as that lies within the sampling; negative if early."""
        return self.errors(hypothesis).late(SAMPLING * self.problem.resolution)

    def on_time(self, hypothesis: Hypothesis) -> Errors:
        """Errors with the free run moved to where it fits best, by less than a sample period."""
        return self.errors(hypothesis).moved(self.late(hypothesis))

    def _gains(self, before: Errors, after: Errors) -> bool:
        """Whether the errors `after` are smaller, by more than chance.

        They are the noise of the water, summed up by the vehicle; what an effect changes may be small beside that and
        yet certain. So they are compared as they are, and by the likelihood of what the noise makes of a free run. But
        a torque that answers the noise carries it into the free run.
        """
        gain = _gain(before, after)
        if gained(gain) or not self.weighs:
            return gained(gain)
        lost = gain.mean() < -LOST * gain.std() / np.sqrt(gain.size)
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
            return errors_on(self.validation, [(self.problem, hypothesis, spans) for spans in self._held_out()])
        fits = []
        for fold in self._held_out():
            used = np.ones(len(self.problem.blocks), dtype=bool)
            for piece in fold:
                used[piece] = False
            reduced = replace(self.problem, blocks=self.problem.blocks.only(used))
            fits.append((reduced, refit(reduced, hypothesis, refine=not self.quick), fold))
        return errors_on(self.problem, fits, torque=not self.quick)

    def _held_out(self) -> list[Sequence[slice]]:
        """The pieces of each fold; of validation recordings, to which nothing is fitted, each is one."""
        if self.validation is not None:
            runs = self.validation.blocks
            return [[slice(int(a), int(b)) for a, b in zip(runs.start[:-1], runs.start[1:], strict=True)]]
        folds = QUICK_FOLDS if self.quick else FOLDS
        if len(self.pieces) < FEW:  # a third of so short recordings may be all that there was of some rate
            folds = len(self.pieces)
        return [self.pieces[fold::folds] for fold in range(folds)]


def _gain(before: Errors, after: Errors) -> Array:
    """(pieces,) fall of the squared free-run errors."""
    return np.array([float(o @ o - n @ n) for o, n in zip(before.free_run, after.free_run, strict=True)])


def refit(problem: Problem, hypothesis: Hypothesis, *, refine: bool = True) -> Hypothesis:
    """The same effects fitted to other blocks."""
    if not hypothesis.terms:
        return nothing(problem)
    terms = hypothesis.values()
    # an instant or a period on the recording's clock stays: no other piece of the recording can tell it
    refined = frozenset(e.key for e in hypothesis.effects if refine and not e.needs_clock)
    # a search asks for many of these: where the inner parameters stay, it makes do with two passes
    return settle(problem, terms, hypothesis, refined, passes=3 if refine else 2)


def _posed(problem: Problem, runs: Sequence[Run]) -> Problem:
    """The validation recordings, posed alike; whether their command is known they must say themselves."""
    others = pose_like(problem, runs)
    known = others.signals.known and others.knows_command(left_over(others, nothing(problem))[0])
    return replace(others, signals=replace(others.signals, known=known))
