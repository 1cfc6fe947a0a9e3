"""Answers from a model over several velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.learning.doubt import MIN_NOISE_SHARE, Doubt, variance_of
from incsvr.learning.kernel import Pivots
from incsvr.learning.prediction import Prediction
from incsvr.learning.several_velocities.several import Several
from incsvr.learning.support import Support
from incsvr.learning.velocities import distances
from incsvr.numerics import Array

OUTSIDE_DISTANCES = 1.25
"""Distances from the nearest vector, in usual ones between neighbouring vectors, from which on a velocity lies outside
the driven cloud. On six simulated vehicles over three velocities the
error outside is 3.6 times that inside after four batches and 2.2 times after twenty; at 2 the worst corners count as
driven."""
USUAL_DISTANCE_QUANTILE = 0.75
"""Quantile of the distances from each vector to its nearest that is their usual distance."""
MIN_DISTANCE_SHARE = 0.02
"""Least of that distance, as a part of the fastest velocities: vectors that lie on each other are one place."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A model over several velocities made ready for questions."""

    model: Support  # the model
    several: Several  # its further velocities
    columns: Pivots  # of the kernel
    scale: float  # of what the kernels hold, the largest that the drag leaves over at a vector [N m]
    largest: float  # the largest damping of the vectors, the prior of each term of the drag [N m]
    doubt: Doubt  # of the surface
    reach: float  # distance from the nearest vector beyond which nothing was driven, in fastest velocities

    @staticmethod
    def of(model: Support) -> Surface:
        several, count, rate = model.several, model.count, model.support_rate
        assert several is not None
        u, z = several.scaled(several.velocity)
        terms = several.terms(u)
        largest = max(float(np.abs(model.support_damping).max()), 1e-9)
        noise = np.maximum(model.sigma * model.spread.at(rate), MIN_NOISE_SHARE * largest)
        scale = max(float(np.abs(model.support_damping - terms @ several.drag).max()), float(noise.max()))
        columns, phi = Pivots.of(z, model.gamma, vanishing=True)
        doubt = Doubt.of(
            np.concatenate((largest * terms.T, scale * phi)),
            variance_of(noise, count, model.correlation, scale),
            float(count @ rate**2) / float(count.sum()),
            model.sigma,
            model.spread,
            model.water,
            model.widening,
        )
        return Surface(model, several, columns, scale, largest, doubt, _reach(u))

    def predict(self, velocity: Array) -> Prediction:
        """The prediction at (n, d) velocities in their units.

        Its doubt is small among the vectors, and the drag's own far from them.

        Raises:
            BadInput: a velocity is not finite.
        """
        if not np.isfinite(velocity).all():
            raise BadInput("a velocity is not finite; give numbers in m/s and rad/s")
        model, several, own = self.model, self.several, velocity[:, 0]
        u, z = several.scaled(velocity)
        phi = self.columns.at(z)
        at_rest = np.exp(-2.0 * model.gamma * np.sum(z * z, axis=1))
        left = self.scale**2 * np.maximum(1.0 - at_rest - np.add.reduce(phi * phi, axis=0), 0.0)
        psi = np.concatenate((self.largest * several.terms(u).T, self.scale * phi))
        noise = self.doubt.noise(own)
        return Prediction(
            several.value(velocity, model.gamma, model.weight),
            np.hypot(noise, self.doubt.at(own, psi, left)),
            self._outside(velocity),
            noise,
            several.derivative(velocity, model.gamma, model.weight),
        )

    def _outside(self, velocity: Array) -> NDArray[np.bool_]:
        """(n,) whether (n, d) velocities lie outside the cloud that was driven."""
        fastest = self.several.fastest
        return np.asarray(distances(velocity / fastest, self.several.velocity / fastest).min(axis=1) > self.reach)


def _reach(u: Array) -> float:
    """The reach of the cloud of (m, d) scaled vectors beyond each of them."""
    if u.shape[0] < 2:
        return MIN_DISTANCE_SHARE
    apart = distances(u, u)
    np.fill_diagonal(apart, np.inf)
    return OUTSIDE_DISTANCES * max(float(np.quantile(apart.min(axis=1), USUAL_DISTANCE_QUANTILE)), MIN_DISTANCE_SHARE)
