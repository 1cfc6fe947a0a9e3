"""A hypothesis moved within its doubt: one deviation along each axis of its covariance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from incsvr.evidence import covariance
from incsvr.tracer.hypothesis import Hypothesis
from incsvr.tracer.problem import Problem

LEAST = 1e-10
"""Of the largest variance, relative to each parameter's, below which an axis holds no doubt."""


def moved(problem: Problem, hypothesis: Hypothesis) -> Iterator[Hypothesis]:
    """The hypothesis with its damping and its parameters one deviation away, along one axis after the other."""
    covered = covariance(problem, hypothesis)
    deviation = np.sqrt(np.maximum(np.diag(covered), 1e-300))
    variance, axes = np.linalg.eigh(covered / np.outer(deviation, deviation))
    for k in np.flatnonzero(variance > LEAST * variance[-1]):
        step = deviation * axes[:, k] * np.sqrt(variance[k])
        theta, at = hypothesis.fit.theta.copy(), problem.coarse.shape[1]
        theta[:at] += step[:at]
        terms = []
        for effect, term in zip(hypothesis.effects, hypothesis.terms, strict=True):
            count, sought = len(term.coefficients), effect.sought
            coefficients = tuple(float(x) for x in term.coefficients + step[at : at + count])
            at += count
            inner = [term.inner[place] + float(by) for place, by in zip(sought, step[at:], strict=False)]
            at += len(sought)
            terms.append(replace(term, coefficients=coefficients, inner=effect.moved(term.inner, inner)))
        yield replace(hypothesis, fit=replace(hypothesis.fit, theta=theta), terms=tuple(terms))
