"""The distance of fresh samples from the served curve, beyond their noise and the curve's uncertainty.

The doubt that a curve has of itself knows noise that is independent of the motion. Water that lasts for minutes, a
correction that was a false alarm, vectors of a vehicle that has changed: none of them is in it, and all of them show in
the next batches. So the samples of a batch are grouped by rate, before they are learned; the mean residual m of each
group is noise of variance s² and the curve's error. Over some batches Σ(m² − s²)/ΣV tells by how much the error exceeds
the variance V that the curve had claimed. Where that is more than one, the curve's doubt is widened by its root; it is
never narrowed, since what is common to all batches does not show.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from incsvr.learning.model import Model
from incsvr.learning.prediction import Prediction
from incsvr.numerics import independent_part
from incsvr.signals.samples import Samples

SIDE_GROUPS = 5
"""Groups of a batch to each side, over the vehicle's rates."""
MIN_GROUP_SAMPLES = 4
"""Samples of a group that tells anything, at least."""
MIN_GROUPS = 5.0
"""Groups from which on they are believed."""
HORIZON_GROUPS = 40.0
"""Groups that the sums stand for, at most: of some ten batches."""
MAX_GROUP_DEVIATIONS = 4.0
"""Deviations that a group counts for, at most: a few outliers must not be the curve's error."""


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Running sums over groups."""

    excess: float = 0.0  # Σ(m² − s²) [N² m²]
    claimed: float = 0.0  # ΣV [N² m²]
    groups: float = 0.0  # that both stand for

    @property
    def widening(self) -> float:
        """The factor on the curve's own uncertainty, at least 1."""
        if self.groups < MIN_GROUPS or not self.excess > self.claimed > 0.0:
            return 1.0
        return sqrt(self.excess / self.claimed)

    def after(self, model: Model, samples: Samples, said: Prediction, fastest: float) -> Disagreement:
        """The disagreement with further samples that a trained model has not learned from.

        Args:
            samples: (n,) of them.
            said: (n,) what the model says at their velocities.
            fastest: the vehicle's largest |r| [rad/s].
        """
        rate, groups = samples.yaw_rate, 2 * SIDE_GROUPS
        group = 2 * np.minimum((SIDE_GROUPS * np.abs(rate) / fastest).astype(np.intp), SIDE_GROUPS - 1) + (rate > 0.0)
        group[said.extrapolated] = groups
        sizes = np.bincount(group, minlength=groups + 1)[:groups]
        there = np.flatnonzero(sizes >= MIN_GROUP_SAMPLES)
        if there.size == 0:
            return self
        mean = (group == there[:, None]) / sizes[there, None]  # of a value's samples, by a product
        doubt = said.doubt
        values = np.array((said.noise * said.noise, doubt * doubt, samples.damping - said.damping))
        level, claim, error = mean.dot(values.T).T
        noise = level / (independent_part(model.correlation) * sizes[there])
        claimed = claim / model.widening**2
        square = np.minimum(error * error, MAX_GROUP_DEVIATIONS**2 * (noise + claimed))
        before = min(self.groups, max(HORIZON_GROUPS - there.size, 0.0))
        kept = before / self.groups if self.groups else 0.0
        return Disagreement(
            kept * self.excess + float(np.add.reduce(square - noise)),
            kept * self.claimed + float(np.add.reduce(claimed)),
            before + there.size,
        )
