"""What an effect of a hypothesis does alone: how much it explains, where it acts, and what its shape may leave."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from incsvr.tracer.hypothesis import Hypothesis, views
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array
from incsvr.tracer.whitening import whiten

CONTRIBUTION = 0.05
"""Least deviation of what an effect alone explains, in deviations of the block residual."""

LARGER = 0.3
"""Of a larger effect's contribution: one that adds less must outdo the other shapes of the larger, too.

What is left of an effect's wrong shape is a function of what it is a function of, and can pass for another."""

PASSING = 0.5
"""Part of what a dead band or a limit takes, above which it is but passed through from one level to the next."""


def lost_in_noise(problem: Problem, hypothesis: Hypothesis) -> list[int]:
    """Which effects explain, each alone, less than CONTRIBUTION; the least first."""
    # the wrong shape of what lasts is no instant: what acts for instants is measured as the likelihood sees it
    size = [unique_share(problem, hypothesis, k, white=e.brief) for k, e in enumerate(hypothesis.effects)]
    return [k for k in sorted(range(len(size)), key=size.__getitem__) if size[k] < CONTRIBUTION]


def in_passing(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    """Part of what the k-th effect takes that it takes in blocks in which the command jumps."""
    taken = np.square(hypothesis.columns[:, hypothesis.position[k]])
    return float(np.sum(taken[problem.blocks.mistimed > 0.0]) / max(np.sum(taken), 1e-300))


def unique_share(problem: Problem, hypothesis: Hypothesis, k: int, *, white: bool = False) -> float:
    """Deviation of what the k-th effect alone explains, in (robust) deviations of the block residual.

    With `white`, of both after the AR filter that makes the noise white: as the likelihood sees them.
    """
    core = _core(hypothesis, k)
    rest = np.delete(hypothesis.columns, core, axis=1)
    part = hypothesis.columns[:, core] @ hypothesis.fit.theta[core] + hypothesis.offsets[k]
    residual = hypothesis.fit.residual
    if white:
        rest, part, residual = (whiten(x, hypothesis.fit.ar, problem.blocks) for x in (rest, part, residual))
    alone = part - rest @ np.linalg.lstsq(rest, part, rcond=1e-10)[0]
    deviation = min(1.4826 * float(np.median(np.abs(residual - np.median(residual)))), float(np.std(residual)))
    return float(np.std(alone)) / max(deviation, 1e-300)


def bends(problem: Problem, hypothesis: Hypothesis, k: int) -> tuple[Array, Array] | None:
    """By what the effects that explain much more than the k-th may differ from their shapes.

    Returns:
        (n_b, c) block means, and (2, n_b, c) how they answer the noise of their block; None if there are none.
    """
    alone = [unique_share(problem, hypothesis, j) for j in range(len(hypothesis.terms))]
    seen = views(problem, hypothesis)
    columns, turned = [], []
    for j, (effect, term) in enumerate(zip(hypothesis.effects, hypothesis.terms, strict=True)):
        # what friction holds at rest may be the larger part of it
        if j == k or (alone[k] >= LARGER * alone[j] and not effect.dry):
            continue
        mean = problem.blocks.mean(effect.bends(seen.of(effect), term))
        scale = np.std(mean, axis=0) + 1e-300  # a cube and a ramp side by side
        columns.append(mean / scale)
        turned.append(seen.answers(effect, partial(effect.bends, term=term), mean) / scale)
    found = np.concatenate(columns, axis=1) if columns else np.zeros((0, 0))
    return (found, np.concatenate(turned, axis=2)) if found.size else None


def _core(hypothesis: Hypothesis, k: int) -> NDArray[np.intp]:
    at = hypothesis.position[k]
    return np.arange(at, at + hypothesis.effects[k].core)


def rose(grown: Hypothesis, base: Hypothesis) -> bool:
    """Whether the raw residual rose, its level apart (that may be the next effect): an AR near a unit root hides it."""

    def spread(h: Hypothesis) -> float:
        return float(np.mean(np.abs(h.fit.residual - np.median(h.fit.residual))))

    return spread(grown) > 1.02 * spread(base)
