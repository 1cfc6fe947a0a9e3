"""How much evidence is asked of an effect."""

from __future__ import annotations

from typing import Protocol

from incsvr.tracing.weak.hypothesis import Hypothesis, price
from incsvr.tracing.weak.problem import Problem

LEAST_GAIN = 12.0
"""Least gain of the criterion by which an effect is added."""

STRONG = 40.0
"""Gain of the criterion that leaves no doubt but that of a biased equation, which a free run would show by its sign."""

LEVEL = 1e-4
"""Largest p-value, corrected for the search, of an effect that is named; AR(3) is not the noise's true colour."""


class FreeRun(Protocol):
    """The judge of every step."""

    def __call__(self, hypothesis: Hypothesis) -> float:
        """Free-run error on unseen data [rad/s]."""
        ...

    def better(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether the free run of `new` is better by more than chance would have it."""
        ...


def penalised_criterion(hypothesis: Hypothesis) -> float:
    """What hypotheses compete by: every named effect must have brought the threshold."""
    return hypothesis.criterion - LEAST_GAIN * len(hypothesis.terms)


def required_gain(problem: Problem, base: Hypothesis, k: int) -> float:
    """2 Δℓ that is asked of the k-th effect: its price and a threshold."""
    effect = base.effects[k]
    return price(effect, effect.core, problem) + LEAST_GAIN
