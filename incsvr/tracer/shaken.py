"""What an effect would be worth in a noisier torque: one that feeds on the noise is worth as much, or more.

A limit or a dead band takes noise out of a torque that dwells at it, and so does any column that is built from the
recorded torque. What truly acts on the vehicle is harder to see the more noise there is: the idea of J. R. Cook and
L. A. Stefanski, "Simulation-extrapolation estimation", JASA 89 (1994).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from incsvr.evidence import gain_of
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle
from incsvr.tracer.noise import calmed, foretell
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array

ADDED = 3.0
"""Variance that is added to the torque's noise, in parts of what is there."""

DRAWS = 2
"""Of noise, over which the evidence is averaged."""


def fed_by_noise(problem: Problem, hypothesis: Hypothesis, k: int) -> bool:
    """Whether the k-th effect explains as much where the torque has four times the noise.

    An effect of the vehicle loses its evidence as the noise grows, in the ratio of the residual's variances; one that
    feeds on it loses none. The line is drawn half way.
    """
    share = problem.signals.share
    kept = 1.0 / (1.0 + ADDED * share)
    before = gain_of(problem, hypothesis, k)
    after = np.mean([_gain(shaken(problem, hypothesis, seed), hypothesis, k) for seed in range(DRAWS)])
    return bool(after > 0.5 * (1.0 + kept) * before)


def shaken(problem: Problem, hypothesis: Hypothesis, seed: int) -> Problem:
    """The equations with more noise of the same colour in the torque."""
    s = problem.signals
    torque = s.torque + np.sqrt(ADDED) * _noise(problem, hypothesis, np.random.default_rng(seed))
    signals = replace(s, torque=torque, share=s.share * (1.0 + ADDED) / (1.0 + ADDED * s.share))
    mean = problem.blocks.mean(torque)
    return replace(
        problem, signals=signals, y=problem.y + mean - problem.blocks.mean(s.torque),
        calm=calmed(signals, problem.blocks.size), foretold=foretell(mean, problem.blocks),
        white=problem.white * float(np.sqrt(1.0 + ADDED)),
    )  # fmt: skip


def _noise(problem: Problem, hypothesis: Hypothesis, random: np.random.Generator) -> Array:
    """(n,) a draw of the torque's noise [N m]: the residual's colour between the blocks, white within them."""
    blocks, fitted = problem.blocks, hypothesis.fit
    slow = lfilter([1.0], np.concatenate([[1.0], -fitted.ar]), random.normal(size=len(blocks)))
    slow = np.clip(slow, -1e3, 1e3) * fitted.scale * np.sqrt(problem.signals.share)
    middle = blocks.first + 0.5 * blocks.size
    course: Array = np.interp(np.arange(len(problem.signals)), middle, slow)
    within = max(problem.white * np.sqrt(blocks.size), 0.0)
    return course + within * random.normal(size=course.size)


def _gain(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    terms = [(e, t.inner, t.coefficients) for e, t in zip(hypothesis.effects, hypothesis.terms, strict=True)]
    searched = frozenset({hypothesis.effects[k].key})
    return gain_of(problem, settle(problem, terms, nothing(problem), searched), k)
