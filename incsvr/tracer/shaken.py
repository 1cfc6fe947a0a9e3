"""A limit or a dead band in a noisier torque: is it worth as much, it feeds on the noise.

Either takes noise out of a torque that dwells at it. What truly acts on the vehicle is harder to see the more noise
there is: the idea of J. R. Cook and L. A. Stefanski, "Simulation-extrapolation estimation", JASA 89 (1994).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from incsvr.evidence import explained, gain_of
from incsvr.tracer.command import told
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array

ADDED = 3.0
"""Variance that is added to the torque's noise, in parts of what is there."""

DRAWS = 2
"""Of noise, over which the evidence is averaged."""


def fed_by_noise(problem: Problem, hypothesis: Hypothesis, k: int) -> bool:
    """Whether the k-th effect explains as much where the torque has four times the noise.

    What an effect of the vehicle explains, in parts of the noise, falls as the noise grows; of one that feeds on it, it
    stays. The line is drawn half way.
    """
    kept = 1.0 / (1.0 + ADDED * problem.signals.share)
    before = explained(problem, gain_of(problem, hypothesis, k))
    after = [explained(problem, _gain(shaken(problem, hypothesis, seed), hypothesis, k)) for seed in range(DRAWS)]
    return bool(np.mean(after) > 0.5 * (1.0 + kept) * before)


def shaken(problem: Problem, hypothesis: Hypothesis, seed: int) -> Problem:
    """The equations with more noise of the same colour in the torque."""
    s = problem.signals
    torque = s.torque + np.sqrt(ADDED) * _noise(problem, hypothesis, np.random.default_rng(seed))
    signals = replace(s, torque=torque, share=s.share * (1.0 + ADDED) / (1.0 + ADDED * s.share))
    mean = problem.blocks.mean(torque)
    return replace(
        problem, signals=signals, y=problem.y + mean - problem.blocks.mean(s.torque),
        command=told(signals, problem.blocks, problem.command),
        white=problem.white * float(np.sqrt(1.0 + ADDED)),
    )  # fmt: skip


def _noise(problem: Problem, hypothesis: Hypothesis, random: np.random.Generator) -> Array:
    """(n,) a draw of the torque's noise [N m]: the residual's colour between the blocks, white within them."""
    blocks, fitted = problem.blocks, hypothesis.fit
    slow = lfilter([1.0], np.concatenate([[1.0], -fitted.ar]), random.normal(size=len(blocks)))
    slow = slow * fitted.scale * np.sqrt(problem.signals.share)
    middle = blocks.first + 0.5 * blocks.size
    course: Array = np.interp(np.arange(len(problem.signals)), middle, slow)
    noise: Array = course + problem.white * np.sqrt(blocks.size) * random.normal(size=course.size)
    return noise


def _gain(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    terms = hypothesis.values()
    searched = frozenset({hypothesis.effects[k].key})
    return gain_of(problem, settle(problem, terms, nothing(problem), searched), k)
