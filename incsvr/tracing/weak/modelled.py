"""A fitted hypothesis as a model that predicts and runs free."""

from __future__ import annotations

import numpy as np
from scipy.optimize import isotonic_regression

from incsvr.tracing.model import TracedModel
from incsvr.tracing.weak.hypothesis import Hypothesis
from incsvr.tracing.weak.problem import Problem


def model_of(problem: Problem, hypothesis: Hypothesis) -> TracedModel:
    """A fitted hypothesis as a model.

    The damping table reaches as far as the fitted blocks did (but for the outermost half per cent). A free run needs
    drag that holds where the data were few: passive, r d(r) ≥ 0, and never less for a faster turn (isotonic
    regression, weighted by how often each rate occurred).
    """
    s, blocks = problem.signals, problem.blocks
    seen = blocks.mean(s.rate)[blocks.used]
    low, high = (float(q) for q in np.quantile(seen, [0.005, 0.995]))
    low, high = min(low, -1e-6), max(high, 1e-6)
    rate = np.unique(np.concatenate([np.linspace(low, 0.0, 101), np.linspace(0.0, high, 101)]))
    curve = problem.grid_columns @ hypothesis.fit.theta[: problem.grid_columns.shape[1]]
    damping = np.interp(rate, problem.grid, curve)
    often = np.histogram(seen, np.concatenate([[-np.inf], 0.5 * (rate[1:] + rate[:-1]), [np.inf]]))[0] + 0.1
    for side in (rate > 0.0, rate < 0.0):
        damping[side] = isotonic_regression(damping[side], weights=often[side]).x
    damping = np.sign(rate) * np.maximum(np.sign(rate) * damping, 0.0)
    residual = hypothesis.fit.residual
    sigma = 1.4826 * float(np.median(np.abs(residual - np.median(residual))))
    return TracedModel(s.inertia, rate, damping, hypothesis.terms, sigma, blocks.period, s.scale, s.origin)
