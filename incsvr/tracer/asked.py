"""How much evidence is asked of an effect: of the equation, or less of it where free runs make up for the rest."""

from __future__ import annotations

from typing import Protocol

from incsvr.evidence import p_value, together
from incsvr.tracer.hypothesis import Hypothesis, price
from incsvr.tracer.problem import Problem
from incsvr.tracer.scan import without

THRESHOLD = 12.0
"""Least gain of the criterion by which an effect is added.

Twice that on one sine for an effect of the motion: of the noise, too, only a few lines count there.
"""

STRONG = 40.0
"""Gain of the criterion that leaves no doubt but that of a biased equation, which a free run would show by its sign."""

LEVEL = 1e-4
"""Largest p-value, corrected for the search, of an effect that is named; AR(3) is not the noise's true colour."""

WITNESS = 1e-2
"""p-value with which the free runs of held-out pieces tell an effect by themselves."""

HINT = 6.6
"""2 Δℓ of the equation, χ² at 1 %, that is asked of an effect of which free runs leave no doubt."""

WITNESSED = 100.0
"""2 Δℓ on unseen data by which free runs that are driven by the plain command leave none. Of nothing hidden came 40 at
most; of the errors of other effects' shapes more, but the equation holds no hint of these."""

UNSEEN = 1e-6
"""p-value of such free runs: nobody knows their noise so well that they could be believed with less."""


class FreeRun(Protocol):
    """The judge of every step; a `witness` where free runs may tell what the equation but hints at."""

    @property
    def witness(self) -> bool: ...

    def __call__(self, hypothesis: Hypothesis) -> float:
        """Free-run error on unseen data [rad/s]."""
        ...

    def better(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether the free run of `new` is better by more than chance would have it."""
        ...

    def by_chance(self, new: Hypothesis, old: Hypothesis) -> float:
        """p-value of the free run of `new` being better than that of `old`."""
        ...

    def tells(self, new: Hypothesis, old: Hypothesis) -> float:
        """2 Δℓ of `new` over `old` by the errors of their free runs on unseen data."""
        ...

    def needs(self, new: Hypothesis, old: Hypothesis) -> float:
        """The same where either is moved within its doubt to where it runs best."""
        ...


def worth(hypothesis: Hypothesis) -> float:
    """What hypotheses compete by: every named effect must have brought the threshold."""
    return hypothesis.criterion - THRESHOLD * len(hypothesis.terms)


def full(problem: Problem, base: Hypothesis, k: int) -> float:
    """2 Δℓ that is asked of the k-th effect: its price and a threshold; on one sine twice that of an effect of the
    motion."""
    effect = base.effects[k]
    doubled = 2.0 if problem.one_sine and effect.of_phase else 1.0
    return price(effect, effect.core, problem) + doubled * THRESHOLD


def paid(problem: Problem, free_run: FreeRun, base: Hypothesis, k: int, gain: float, among: int) -> float:
    """The same of an effect that brings `gain`, where free runs may make up for a part: the price alone, or less."""
    effect = base.effects[k]
    if witnessed(problem, free_run, base, k, gain):
        return HINT
    least, whole = price(effect, effect.core, problem), full(problem, base, k)
    if (problem.one_sine and effect.of_phase) or not least < gain < whole:
        return whole
    return least if told(problem, free_run, base, k, gain, among) <= LEVEL else whole


def told(problem: Problem, free_run: FreeRun, base: Hypothesis, k: int, gain: float, among: int) -> float:
    """p-value of the k-th effect as the equation tells it by `gain`, corrected for a search among so many; where that
    leaves a doubt, together with free runs of held-out pieces, if they tell it, too.

    A controller carries the noise into the free runs: there they are no second witness.
    """
    effect = base.effects[k]
    p = p_value(gain, effect.core + len(effect.sought), effect.looks * max(among, 1))
    if p > LEVEL and witnessed(problem, free_run, base, k, gain):
        return together(p, UNSEEN)
    if p <= LEVEL or p > WITNESS or problem.closed_loop:
        return p
    seen = free_run.by_chance(base, without(problem, base, k))
    return together(p, seen) if seen < WITNESS else p


def witnessed(problem: Problem, free_run: FreeRun, base: Hypothesis, k: int, gain: float) -> bool:
    """Whether free runs leave no doubt of the k-th effect, of which the equation has but a hint, its 2 Δℓ `gain`.

    Where the torque's noise is the sensor's and the command is known, they see none of it, and the equation all. Their
    likelihood ratio on unseen data bounds the p-value by exp(−Δℓ), whatever was searched (L. Wasserman, A. Ramdas,
    S. Balakrishnan, "Universal inference", PNAS 117, 2020). But that noise has moved the other effects' parameters, and
    what makes up for them alone runs better, too: it must be as much with either set where the free runs want it.
    """
    if not free_run.witness or gain <= HINT:
        return False
    less = without(problem, base, k)
    return free_run.tells(base, less) > WITNESSED and free_run.needs(base, less) > WITNESSED
