"""What some samples say of each of several causes, beside what is usual: marginal likelihoods in closed form from sums.

    e = X u + s c + noise,   u ~ N(0, P⁻¹),   s ~ N(μ, σ²) for one cause c at a time, or s = 0

Of the samples nothing is needed but the sums of squares and products of the columns and of e, in variances of the
noise: they are the same whichever cause is asked, and add up over time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Evidence:
    """M causes, weighed.

    Attributes:
        nothing: ln p(e) where there is none; a constant of these samples is left out.
        odds: (M,) ln of the evidence of each over that.
        cost: (M,) what each leaves of e, and takes of its prior, in variances.
        size, deviation: (M,) s and its deviation.
        usual: (m, M + 1) u beside each, and beside nothing.
        precision: (m, m) of u beside nothing.
    """

    nothing: float
    odds: Array
    cost: Array
    size: Array
    deviation: Array
    usual: Array
    precision: Array

    @staticmethod
    def of(sums: Array, prior: Array, directions: Array, mean: Array, spread: Array) -> Evidence:
        """Weighs the causes.

        Args:
            sums: (q + 1, q + 1) of q columns, of which the first m are what is usual, and of e.
            prior: (m, m) P.
            directions: (q, M) what one of each cause is in the columns.
            mean, spread: (M,) μ and σ.
        """
        m, gram, with_e = len(prior), sums[:-1, :-1], sums[:-1, -1]
        precision = gram[:m, :m] + prior
        inverse = np.linalg.inv(precision)
        usual = inverse @ with_e[:m]
        alone = float(sums[-1, -1] - with_e[:m] @ usual)
        power = gram @ directions
        beside, square = power[:m], np.sum(directions * power, axis=0)
        taken = inverse @ beside
        # the prior's mean is taken from e, so that what is left of s is about zero
        pull = directions.T @ with_e - beside.T @ usual
        info = square - np.sum(beside * taken, axis=0)
        deviation = (info + spread**-2.0) ** -0.5
        more = (pull - mean * info) * deviation**2
        cost = alone - 2.0 * mean * pull + mean**2 * info - (more / deviation) ** 2
        size = mean + more
        sizes = np.linalg.slogdet(np.stack((precision, prior)))[1]
        return Evidence(
            -0.5 * (alone + float(sizes[0] - sizes[1])),
            0.5 * (alone - cost) + np.log(deviation / spread),
            cost,
            size,
            deviation,
            np.column_stack((usual[:, None] - taken * size, usual)),
            precision,
        )
