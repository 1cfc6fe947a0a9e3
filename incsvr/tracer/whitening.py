"""Regression whose noise is coloured and has outliers: AR(3) by Burg's method, Student-t innovations.

Sources: J. P. Burg, "Maximum entropy spectral analysis" (1975); K. L. Lange, R. J. A. Little, J. M. G. Taylor, "Robust
statistical modeling using the t distribution", JASA 84 (1989), for the weights (ν + 1)/(ν + (e/s)²).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln

from incsvr.tracer.run import Array
from incsvr.tracer.weak_form import Blocks

DEGREES = 6.0
"""ν of the innovations: outliers of a few per cent cost nothing, Gaussian noise costs 4 % of the efficiency."""

RIDGE = 1e-7
"""Of the mean squared column: holds spline coefficients where the vehicle hardly was."""


@dataclass(frozen=True, slots=True)
class Fit:
    """y = X θ + u, u an AR(3) with Student-t innovations of scale s.

    Attributes:
        theta: (p,).
        ar: (3,) u_t = Σ ar_k u_{t−k} + e_t.
        scale: s, in the unit of y.
        log_likelihood: of the innovations.
        residual: (n_b,) u.
        innovation: (m,) e of the blocks with three predecessors.
        weight: (m,) weight of each innovation, near one for a Gaussian one, small for an outlier.
        normal: (p, p) Xᵀ W X of the whitened columns, divided by s².
    """

    theta: Array
    ar: Array
    scale: float
    log_likelihood: float
    residual: Array
    innovation: Array
    weight: Array
    normal: Array


def burg(residual: Array, blocks: Blocks, order: int = 3) -> Array:
    """AR coefficients of `residual`, pooled over the runs; outliers are drawn in to four deviations first."""
    limit = 4.0 * max(1.4826 * float(np.median(np.abs(residual[blocks.used]))), 1e-12)
    forward = np.where(blocks.used, np.clip(residual, -limit, limit), 0.0)
    backward = forward.copy()
    position = np.arange(residual.size) - np.repeat(blocks.start[:-1], np.diff(blocks.start))
    ar = np.zeros(0)
    for k in range(1, order + 1):
        here = np.flatnonzero(position >= k)
        f, b = forward[here], backward[here - 1]
        power = float(f @ f + b @ b)
        reflection = 2.0 * float(f @ b) / power if power > 0.0 else 0.0
        ar = np.concatenate([ar - reflection * ar[::-1], [reflection]])
        forward, backward = forward.copy(), backward.copy()
        forward[here], backward[here] = f - reflection * b, b - reflection * f
    return ar


def whiten(values: Array, ar: Array, blocks: Blocks) -> Array:
    """The AR filter over blocks with three predecessors; `values` (n_b,) or (n_b, p)."""
    white: Array = values[3:] - ar[0] * values[2:-1] - ar[1] * values[1:-2] - ar[2] * values[:-3]
    # rows of one run need no selection: copying them is most of the cost
    return white if blocks.whole.size == white.shape[0] else white[blocks.whole - 3]


def fit(y: Array, columns: Array, blocks: Blocks, start: Fit | None = None, rounds: int = 4) -> Fit:
    """Maximum likelihood of θ, the AR and s, each in turn.

    Args:
        y: (n_b,) left-hand side of every block.
        columns: (n_b, p).
        start: an earlier fit whose AR and residual weights begin the search.
        rounds: of AR estimation; within each, three reweighted least squares.
    """
    p = columns.shape[1]
    ridge = np.diag(RIDGE * np.einsum("ij,ij->j", columns, columns) + 1e-300)
    ar = np.zeros(3) if start is None else start.ar
    weight = np.ones(blocks.whole.size)
    if start is not None and start.weight.size == weight.size:
        weight = start.weight
    theta, scale, residual = np.zeros(p), 1.0, y
    for turn in range(rounds):
        white_x, white_y = whiten(columns, ar, blocks), whiten(y, ar, blocks)
        for _ in range(3):
            weighted = white_x * weight[:, None]
            normal = weighted.T @ white_x
            theta = np.linalg.solve(normal + ridge, weighted.T @ white_y)
            innovation = white_y - white_x @ theta
            scale = max(float(np.mean(weight * innovation**2)), 1e-24) ** 0.5
            weight = (DEGREES + 1.0) / (DEGREES + (innovation / scale) ** 2)
        residual = y - columns @ theta
        if turn + 1 < rounds:
            ar = burg(residual, blocks)
    scale = max(float(np.mean(weight * innovation**2)), 1e-24) ** 0.5
    likelihood = log_likelihood(innovation, scale)
    return Fit(theta, ar, scale, likelihood, residual, innovation, weight, normal / scale**2)


def log_likelihood(innovation: Array, scale: float) -> float:
    """Student-t log likelihood of the innovations."""
    constant = gammaln(0.5 * (DEGREES + 1.0)) - gammaln(0.5 * DEGREES) - 0.5 * np.log(np.pi * DEGREES)
    tail = 0.5 * (DEGREES + 1.0) * np.log1p((innovation / scale) ** 2 / DEGREES)
    return float(innovation.size * (constant - np.log(scale)) - np.sum(tail))
