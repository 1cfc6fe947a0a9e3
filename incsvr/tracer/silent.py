"""Inside a dead band the command moves and the vehicle does not: what the plain thrust leaves must be louder there.

A torque that rests at nothing holds noise alone, and a band takes that as it takes a command: the equation gets better
by it, and the free run. But noise is as loud inside the band as elsewhere; of a command that the vehicle does not
answer, its own movement is added.
"""

from __future__ import annotations

import numpy as np

from incsvr.tracer.hypothesis import Hypothesis, left_over
from incsvr.tracer.problem import Problem

LOUDER = 1.2
"""Mean square of the residual inside the band, in that of the noise elsewhere, that is asked for. Of noise it was 1.1 at
most, of dead bands 1.3 to 50."""

FEWEST = 20
"""Blocks on either side from which that is told."""


def but_noise(problem: Problem, hypothesis: Hypothesis, less: Hypothesis, k: int) -> bool:
    """Whether, where the k-th effect lets nothing through, the torque is no louder than its noise elsewhere.

    Args:
        less: the same without that effect, settled. Which blocks are inside is told from the motion alone.
    """
    blocks, effect, term = problem.blocks, hypothesis.effects[k], hypothesis.terms[k]
    noise, taken = left_over(problem, hypothesis)
    plain = left_over(problem, less)[0]
    inside = effect.silent(blocks.mean(problem.signals.torque - taken[term.effect]) - noise, term)
    calm = blocks.mistimed == 0.0
    within, elsewhere = plain[inside & calm], noise[~inside & calm]
    if min(within.size, elsewhere.size) < FEWEST:
        return False
    return float(np.mean(within**2)) < LOUDER * float(np.mean(elsewhere**2))
