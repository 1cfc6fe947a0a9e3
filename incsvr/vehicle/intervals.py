"""Intervals of 95 % of a vehicle's parameters, from fits that each lack one block of the recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from incsvr.numerics import Array
from incsvr.vehicle.fitting import DEGREES_OF_FREEDOM, PRIOR_SCALES, Fit, normal_equations

CONFIDENCE = 0.95
"""Confidence of the intervals."""
MAX_BLOCKS = 24
"""Blocks that are left out in turns. Each lasts long beside what disturbs a vehicle, and so many leave Student's t near
a normal law: 12 to 32 held the truth alike on simulated vehicles."""


@dataclass(frozen=True, slots=True)
class Scatter:
    """How a fit's parameters move where one block of windows after the other is left out.

    Attributes:
        moved: (blocks, size) the parameters without each block, less their mean.
        information: (blocks, size, size) what each block tells of the parameters if all windows err alike.
        inverse: (size, size) inverse of all information: the covariance if they do.
    """

    moved: Array
    information: Array
    inverse: Array

    @staticmethod
    def of(fitted: Fit) -> Scatter:
        """That of a fit; each fit without a block is one Newton step from the whole one."""
        windows = fitted.error.shape[0]
        number = min(MAX_BLOCKS, windows)
        blocks = np.arange(windows) * number // windows
        parts = [_of_block(fitted, blocks == k) for k in range(number)]
        curvature, information, gradient = (np.stack(each) for each in zip(*parts, strict=True))
        prior = np.diag(1.0 / (PRIOR_SCALES * fitted.scale) ** 2)
        rest = curvature.sum(axis=0) + prior - curvature
        moved = np.linalg.solve(rest, gradient[..., None])[..., 0]
        inverse = np.linalg.inv(information.sum(axis=0) + prior)
        return Scatter(np.asarray(moved - moved.mean(axis=0)), information, np.asarray(inverse))

    def errors(self, along: Array) -> Array:
        """(n,) standard errors of combinations (n, size) of the parameters: the jackknife over blocks.

        Errors may be of any size and colour within a block.
        """
        number = self.moved.shape[0]
        return np.asarray(np.sqrt(np.sum((self.moved @ along.T) ** 2, axis=0) * ((number - 1.0) / number)))

    def errors_if_alike(self, along: Array) -> Array:
        """(n,) standard errors of combinations (n, size) if all windows err alike, a window counting as one number."""
        return np.asarray(np.sqrt(np.einsum("np,pq,nq->n", along, self.inverse, along)))

    def freedom(self, along: Array) -> Array:
        """(n,) degrees of freedom of `errors`: the fewer, the more a combination (n, size) rests on a few blocks.

        Satterthwaite's, from the part of each block in the variance (R. M. Bell and D. F. McCaffrey, Bias reduction in
        standard errors for linear regression with multi-stage samples, Survey Methodology 28, 2002).
        """
        pull = along @ self.inverse
        shares = np.einsum("np,bpq,nq->nb", pull, self.information, pull)
        return np.asarray(np.clip(shares.sum(axis=1) ** 2 / np.sum(shares**2, axis=1), 1.0, self.moved.shape[0] - 1.0))


def intervals(fitted: Fit, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """Lower and upper ends (size,) each, within the bounds of physics."""
    scatter, each = Scatter.of(fitted), np.eye(fitted.parameters.size)
    reach = student.ppf(0.5 * (1.0 + CONFIDENCE), scatter.freedom(each)) * scatter.errors(each)
    return np.maximum(fitted.parameters - reach, bounds[0]), np.minimum(fitted.parameters + reach, bounds[1])


def _of_block(fitted: Fit, inside: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Curvature and information (size, size) and slope (size,) of the criterion in some windows.

    Student's criterion bends less than its weights say, because a weight falls as its window's error grows. Where the
    error is so large that the criterion would bend downwards, it counts as straight.
    """
    slope, error, weight = fitted.slope[:, inside], fitted.error[inside], fitted.weight[inside]
    normal, gradient = normal_equations(slope, error, weight)
    along = np.einsum("pwca,wca->pwa", slope, error) / error.shape[1]
    square = np.mean(error**2, axis=1) + 1e-300
    less = weight * np.minimum(2.0 / (DEGREES_OF_FREEDOM * fitted.variance + square), 1.0 / square)
    flat = along.reshape(along.shape[0], -1)
    return normal - (flat * less.ravel()) @ flat.T, normal, gradient
