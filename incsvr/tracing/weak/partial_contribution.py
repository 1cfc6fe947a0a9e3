"""What an effect of a hypothesis does alone: how much it explains, where it acts, and what its shape may leave."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.weak.hypothesis import Hypothesis
from incsvr.tracing.weak.problem import Problem

CONTRIBUTION = 0.05
"""Least deviation of what an effect alone explains, in deviations of the block residual."""

PASSING = 0.5
"""Part of what a dead band or a limit takes, above which it is but passed through from one level to the next."""


def lost_in_noise(hypothesis: Hypothesis) -> list[int]:
    """Which effects explain, each alone, less than CONTRIBUTION; the least first."""
    size = [partial_contribution(hypothesis, k) for k in range(len(hypothesis.terms))]
    return [k for k in sorted(range(len(size)), key=size.__getitem__) if size[k] < CONTRIBUTION]


def in_passing(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    """Part of what the k-th effect takes that it takes in blocks in which the command jumps."""
    taken = np.square(hypothesis.columns[:, hypothesis.position[k]])
    return float(np.sum(taken[problem.blocks.mistimed > 0.0]) / max(np.sum(taken), 1e-300))


def partial_contribution(hypothesis: Hypothesis, k: int) -> float:
    """Deviation of what the k-th effect alone explains, in (robust) deviations of the block residual."""
    core = _core(hypothesis, k)
    rest = np.delete(hypothesis.columns, core, axis=1)
    part = hypothesis.columns[:, core] @ hypothesis.fit.theta[core] + hypothesis.offsets[k]
    residual = hypothesis.fit.residual
    alone = part - rest @ np.linalg.lstsq(rest, part, rcond=1e-10)[0]
    deviation = min(1.4826 * float(np.median(np.abs(residual - np.median(residual)))), float(np.std(residual)))
    return float(np.std(alone)) / max(deviation, 1e-300)


def _core(hypothesis: Hypothesis, k: int) -> NDArray[np.intp]:
    at = hypothesis.position[k]
    return np.arange(at, at + hypothesis.effects[k].core)


def rose(grown: Hypothesis, base: Hypothesis) -> bool:
    """Whether the raw residual rose, its level apart (that may be the next effect): an AR near a unit root hides it."""

    def spread(h: Hypothesis) -> float:
        return float(np.mean(np.abs(h.fit.residual - np.median(h.fit.residual))))

    return spread(grown) > 1.02 * spread(base)
