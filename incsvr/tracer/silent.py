"""Inside a dead band the command moves and the vehicle does not: what the plain thrust leaves must be louder there.

A torque that rests at nothing holds noise alone, and a band takes that as it takes a command: the equation gets better
by it, and the free run. But noise is as loud inside the band as elsewhere; of a command that the vehicle does not
answer, its own movement is added. And what a band takes of larger commands it explains where the vehicle moves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.tracer.colour import DEGREES
from incsvr.tracer.hypothesis import Hypothesis, left_over
from incsvr.tracer.problem import Problem

LOUDER = 1.2
"""Mean square of the residual inside the band, in that of the noise elsewhere, that is asked for. Of noise it was 1.1
at most, of most dead bands 1.3 to 50."""

OUTSIDE = 20.0
"""2 Δℓ that the blocks outside must bring where it is not: of noise it was below 0, of other dead bands above 40."""

FEWEST = 20
"""Blocks on either side from which either is told."""


def but_noise(problem: Problem, hypothesis: Hypothesis, less: Hypothesis, k: int) -> bool:
    """Whether the k-th effect explains next to nothing but where it lets nothing through, and what it takes there is
    no louder than the noise elsewhere.

    Args:
        less: the same without that effect, settled. Which blocks are inside is told from the motion alone.
    """
    blocks, effect, term = problem.blocks, hypothesis.effects[k], hypothesis.terms[k]
    noise, taken = left_over(problem, hypothesis)
    inside = effect.silent(blocks.mean(problem.signals.torque - taken[term.effect]) - noise, term)
    calm = blocks.mistimed == 0.0
    within, elsewhere = left_over(problem, less)[0][inside & calm], noise[~inside & calm]
    if min(within.size, elsewhere.size) < FEWEST:
        return False
    louder = float(np.mean(within**2)) >= LOUDER * float(np.mean(elsewhere**2))
    return not louder and _gain(hypothesis, less, calm & ~inside, problem) < OUTSIDE


def _gain(hypothesis: Hypothesis, less: Hypothesis, used: NDArray[np.bool_], problem: Problem) -> float:
    """2 Δℓ of the innovations of the blocks that are `used`, with the three before them."""
    far = used.copy()
    for before in (1, 2, 3):
        far[before:] &= used[:-before]
    far = far[problem.blocks.whole]
    old, new = (np.square(h.fit.innovation[far] / hypothesis.fit.scale) for h in (less, hypothesis))
    return float((DEGREES + 1.0) * np.sum(np.log1p(old / DEGREES) - np.log1p(new / DEGREES)))
