"""Regression whose noise is coloured and has outliers: AR(3), Student-t innovations.

Source: K. L. Lange, R. J. A. Little, J. M. G. Taylor, "Robust statistical modeling using the t distribution", JASA 84
(1989), for the weights (ν + 1)/(ν + (e/s)²).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.blas import daxpy
from scipy.special import gammaln

from incsvr.tracing.run import Array
from incsvr.tracing.weak.jacobian import answering, curvature, log_determinant, moved, pull
from incsvr.tracing.weak.noise_autocorrelation import DEGREES, autoregression, jump_variance, scale_of
from incsvr.tracing.weak.weak_form import Blocks

FARTHEST = 1.5
"""Scale of the innovations, in that of least squares, up to which the Jacobian pulls: the larger the scale, the further
it pulls, and where hardly a command moves the vehicle without end."""

FEWEST_JUMPS = 20
"""Of the command, from which the variance of their instants is told."""

INSTANT = 1.0 / 3.0
"""Most of that: as likely anywhere from a sample period too early to one too late. What is more is no noise."""

RIDGE = 1e-7
"""Of each column's square."""

STIFF = 1e-4
"""Of the mean square of a spline's columns: weight of its second differences. Where the vehicle hardly was it goes on
as it came (P. H. C. Eilers, B. D. Marx, "Flexible smoothing with B-splines and penalties", Statistical Science 11(2),
1996); elsewhere the data have ten thousand times the say."""


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
        weight: (m,) weight of each innovation, near one for a Gaussian one, small for an outlier or where the
            command jumped.
        jump_noise: variance of a jump's instant [sample periods²], in that of the innovations [1/(N m)²].
    """

    theta: Array
    ar: Array
    scale: float
    log_likelihood: float
    residual: Array
    innovation: Array
    weight: Array
    jump_noise: float


def ridge(squares: Array, spline: int) -> Array:
    """(p, p) what is added to a regression's matrix so that it holds where there are next to no data.

    Args:
        squares: (p,) sum of each column's squares.
        spline: how many of the first columns are a spline's, the last of whose coefficients is zero.
    """
    penalty: Array = np.diag(RIDGE * squares + 1e-300)
    if spline:
        second_difference = np.diff(np.eye(spline + 1), 2, axis=0)[:, :spline]
        penalty[:spline, :spline] += STIFF * float(np.mean(squares[:spline])) * second_difference.T @ second_difference
    return penalty


def whiten(values: Array, ar: Array, blocks: Blocks) -> Array:
    """The AR filter over blocks with three predecessors; `values` (n_b,) or (n_b, p), of which it may be a view."""
    white = values[3:]
    if ar.any() and values.size:
        # column after column as one: what one would hand to the next stands in the three rows that are left out
        every = values.ravel(order="F")
        filtered = every.copy()
        for k, part in enumerate(ar.tolist(), 1):
            filtered = daxpy(every, filtered, n=every.size - k, a=-part, offy=k)
        white = filtered.reshape(values.shape, order="F")[3:]
    return white if blocks.with_history.size == white.shape[0] else white.T.take(blocks.with_history - 3, axis=-1).T


def fit(
    y: Array,
    columns: Array,
    blocks: Blocks,
    start: Fit | None = None,
    rounds: int = 4,
    jacobian: Array | None = None,
    gyro_noise_correction: Array | None = None,
    spline: int = 0,
) -> Fit:
    """Maximum likelihood of θ, the AR and s, each in turn.

    The likelihood is that of the motion: where the noise u turned the vehicle and with it the columns, its density
    holds the Jacobian Σ ln((1 + jacobian₀ θ)/(1 + jacobian₁ θ)), without which drag and inertia would be
    underestimated.

    Args:
        y: (n_b,) left-hand side of every block.
        columns: (n_b, p).
        start: an earlier fit whose AR and residual weights begin the search.
        rounds: of AR estimation; within each, three reweighted least squares (two where `start` has good weights) and
            as many of Newton's steps with the Jacobian, both with the matrix of the first.
        jacobian: (2, n_b, p) how the columns answer the noise of their block, relative to I₀ Δr/T_b, and to the
            residual that was taken out of what they see; None if they do not.
        gyro_noise_correction: (p,) part of the innovations' variance by which a column follows them though nothing
            turned, as Δr follows the gyro's noise: the score is corrected for it (L. A. Stefanski, R. J. Carroll,
            Biometrika 74, 1987), and the likelihood for what a smaller coefficient wins by less of that noise alone.
        spline: how many of the first columns are the damping's spline, for `ridge`.
    """
    p, columns = columns.shape[1], np.asfortranarray(columns)  # every sum below runs along the blocks
    penalty = ridge(np.einsum("ij,ij->j", columns, columns), spline)
    ar = np.zeros(3) if start is None else start.ar
    weight = np.ones(blocks.with_history.size)
    if start is not None and start.weight.size == weight.size:
        weight = start.weight
    theta, scale, residual = np.zeros(p), 1.0, y
    steps = 3 if start is None else 2
    jumped = blocks.mistimed[blocks.with_history] > 0.0
    several = bool(np.count_nonzero(jumped) >= FEWEST_JUMPS)
    jump_noise = start.jump_noise if start is not None and several else 0.0
    own = answering(jacobian, blocks)
    lost = np.zeros(p) if gyro_noise_correction is None else gyro_noise_correction * blocks.with_history.size
    corrected = bool(own) or bool(lost.any())
    shrunk_before: list[Array] | None = None
    for turn in range(rounds):
        white_x, white_y = whiten(columns, ar, blocks), whiten(y, ar, blocks)
        innovation, most = white_y - white_x @ theta, np.inf
        jumps = jump_variance(ar, blocks)
        level = 1.0 + jump_noise * jumps
        weighted = np.empty_like(white_x)
        # least squares comes first; later rounds go on from where the Jacobian had led
        initial_steps = 0 if turn > 0 or not corrected else steps
        for step in range(initial_steps + steps):
            if step in (0, initial_steps):  # a matrix of squares is half of a step, and the weights hardly change it
                np.multiply(white_x, np.sqrt(weight)[:, None], out=weighted)
                squares = weighted.T @ weighted + penalty
            toward = white_x.T @ (weight * innovation) - penalty @ theta
            if corrected and step >= initial_steps:
                shrunk = [answer.shrink(theta) for answer in own]
                if step == initial_steps:
                    least = innovation - white_x @ np.linalg.solve(squares, toward)
                    most = FARTHEST * scale_of(weight, least)
                if shrunk_before is None or moved(shrunk, shrunk_before):
                    shrunk_before, curved = shrunk, curvature(own, shrunk, p)
                toward += scale**2 * (pull(own, shrunk, p) + lost)
                theta = theta + np.linalg.solve(squares + scale**2 * curved, toward)
            else:
                theta = theta + np.linalg.solve(squares, toward)
            innovation = white_y - white_x @ theta
            scale = min(scale_of(weight, innovation), most)
            square = (innovation / scale) ** 2
            if several:
                usual = level * (DEGREES + 1.0) / (DEGREES + square / level) * square / level
                jump_noise = float(np.sum(usual[jumped] - 1.0) / np.sum(jumps[jumped]))
                jump_noise = min(max(jump_noise, 0.0), INSTANT / scale**2)
                level = 1.0 + jump_noise * jumps
            weight = (DEGREES + 1.0) / (DEGREES * level + square)
        residual = y - columns @ theta
        if turn + 1 < rounds:
            ar = autoregression(residual, blocks, jump_noise)
    scale = scale_of(weight, innovation)
    likelihood = log_likelihood(innovation / np.sqrt(level), scale) - 0.5 * float(np.sum(np.log(level)))
    likelihood += min(float(lost @ theta), 0.0)
    likelihood += log_determinant(own, theta)
    return Fit(theta, ar, scale, likelihood, residual, innovation, weight, jump_noise)


def without_jump_noise(fitted: Fit) -> Fit:
    """The fit with the weights as they are where a jump of the command adds nothing to its block."""
    weight = (DEGREES + 1.0) / (DEGREES + np.square(fitted.innovation / fitted.scale))
    return replace(fitted, weight=weight, jump_noise=0.0)


def jump_noise_factor(fitted: Fit, blocks: Blocks) -> Array:
    """(m,) by how much an innovation is larger for the jumps of the command in its block and the three before."""
    return np.sqrt(1.0 + fitted.jump_noise * jump_variance(fitted.ar, blocks))


def log_likelihood(innovation: Array, scale: float) -> float:
    """Student-t log likelihood of the innovations."""
    constant = gammaln(0.5 * (DEGREES + 1.0)) - gammaln(0.5 * DEGREES) - 0.5 * np.log(np.pi * DEGREES)
    tail = 0.5 * (DEGREES + 1.0) * np.log1p((innovation / scale) ** 2 / DEGREES)
    return float(innovation.size * (constant - np.log(scale)) - np.sum(tail))
