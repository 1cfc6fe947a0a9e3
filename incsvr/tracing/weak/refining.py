"""An effect's inner parameter found again, beside damping and other effects as they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from incsvr.effects import Effect, Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.damping import SPLINE
from incsvr.tracing.weak.jacobian import answering, curvature, pull
from incsvr.tracing.weak.weak_form import Blocks
from incsvr.tracing.weak.whitening import Fit, ridge, whiten

TOLERANCE = 0.01
"""Of the range in which the parameter is sought."""


def refined(
    y: Array,
    blocks: Blocks,
    effect: Effect,
    seen: Signals,
    inner: tuple[float, ...],
    coefficients: tuple[float, ...],
    columns: Sequence[Array],
    jacobians: Sequence[Array],
    k: int,
    start: Fit,
    most: int,
    place: int,
) -> tuple[float, ...]:
    """The inner parameters with the one at this place found again.

    The colour, the weights and what the Jacobian pulls are those of `start`: what is left is linear in all but the
    parameter. The squares with these weights touch the t likelihood where they were told and lie below it elsewhere, so
    that it never falls (Lange, Little and Taylor's EM); the fit that follows tells them, and the Jacobian, anew.

    Args:
        columns: (n_b, p_j) of the damping and of each effect, of which the k-th are this one's.
        jacobians: (2, n_b, p_j) how these answer the noise.
        most: evaluations.
    """

    def moved(value: float) -> tuple[float, ...]:
        return (value, *inner[1:]) if place == 0 else (*inner[:-1], value)

    def own(value: float) -> Array:
        mean = blocks.mean(effect.columns(seen, moved(value), coefficients))
        return root[:, None] * whiten(mean, start.ar, blocks)

    low, high = effect.shapes if place == 0 and effect.shapes else effect.bracket(seen, inner)
    if not low < high:
        return inner
    root = np.sqrt(start.weight)
    at = sum(part.shape[1] for part in columns[:k])
    width = columns[k].shape[1]
    others = np.concatenate([part for j, part in enumerate(columns) if j != k], axis=1)
    rest = root[:, None] * whiten(np.asfortranarray(others), start.ar, blocks)
    left = root * whiten(y, start.ar, blocks)
    # the Jacobian's quadratic about the start; an effect with a fixed coefficient has no column of its own
    theta, order = start.theta, np.r_[0:at, at + width : start.theta.size, at : at + width]
    if effect.fixed_coefficient:
        order = order[:-width]
    theta = theta[order]
    answers = answering(np.concatenate(jacobians, axis=2)[:, :, order], blocks)
    shrunk = [answer.shrink(theta) for answer in answers]
    curved = start.scale**2 * curvature(answers, shrunk, theta.size)
    pulled = start.scale**2 * pull(answers, shrunk, theta.size) + curved @ theta
    squares, along = rest.T @ rest, rest.T @ left

    def unexplained(value: float) -> float:
        column = own(value)
        if effect.fixed_coefficient:
            normal, right = squares, along - rest.T @ column[:, 0]
            total = float(np.sum(np.square(left - column[:, 0])))
        else:
            cross = rest.T @ column
            normal = np.block([[squares, cross], [cross.T, column.T @ column]])
            right, total = np.concatenate([along, column.T @ left]), 0.0
        normal = normal + ridge(np.diag(normal), SPLINE) + curved
        right = right + pulled
        return total - float(right @ np.linalg.solve(normal, right))

    best = minimize_scalar(
        unexplained, bounds=(low, high), method="bounded", options={"xatol": TOLERANCE * (high - low), "maxiter": most}
    )
    return moved(float(best.x)) if best.fun <= unexplained(inner[place]) else inner
