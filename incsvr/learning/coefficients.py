"""The textbook's coefficients of a learned curve: d(r) = N_r r + N_{r|r|} r|r|, with intervals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from incsvr.learning.model import Model

COEFFICIENT_NAMES = ("N_r", "N_r|r|")
"""Names of the two coefficients, as CONTRACT has them."""
NORMAL_95_DEVIATIONS = 1.96
"""Half width of an interval of 95 % in standard deviations."""


class Interval(NamedTuple):
    """A coefficient and its interval of 95 % [N m s/rad], or [N m s²/rad²]."""

    estimate: float
    low: float
    high: float


def negative_drag(name: str, low: float, high: float) -> str | None:
    """A sentence on a coefficient whose interval of 95 % holds a drag that drives the vehicle; None where it does not.

    Args:
        name: of COEFFICIENT_NAMES, or as the axis calls it.
        low, high: the interval, positive where damping opposes.
    """
    if low >= 0.0:
        return None
    if high <= 0.0:
        return (
            f"{name} drives instead of damping: use it within the rates that were learned, and together with the other"
        )
    return f"{name} has an uncertain sign: its interval contains a negative drag, which drives instead of damping"


def coefficients(model: Model) -> dict[str, Interval]:
    """The best N_r and N_{r|r|} of a trained model's curve, positive where damping opposes.

    Weighted least squares over the vectors, each as sure as its samples make it. Their covariance is scaled until the
    band of the two is as wide as the band of the curve, in the mean over the vectors: what the curve is in doubt about
    beyond the noise, they are too. How far the curve is from this form is not in it.
    """
    rate = model.support_rate
    said = model.predict(rate)
    terms = np.column_stack((rate, rate * np.abs(rate)))
    weighted = terms * model.count[:, None]
    # pinv: at one rate alone the two cannot be told apart.
    covariance = np.linalg.pinv(weighted.T @ terms)
    best = covariance @ (weighted.T @ said.damping)
    own = np.sum(terms @ covariance * terms, axis=1)
    scale = float(np.mean(said.doubt**2)) / max(float(np.mean(own)), 1e-300)
    reach = NORMAL_95_DEVIATIONS * np.sqrt(scale * np.maximum(np.diag(covariance), 0.0))
    return {
        name: Interval(value, value - half, value + half)
        for name, value, half in zip(COEFFICIENT_NAMES, best.tolist(), reach.tolist(), strict=True)
    }
