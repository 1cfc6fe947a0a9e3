"""The additional fields and the predictions of a model over several velocities."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.learning.columns import Pivots
from incsvr.learning.doubt import MIN_NOISE_SHARE, Doubt, variance_of
from incsvr.learning.kernel import rbf_at_rest, rbf_at_rest_slope
from incsvr.learning.prediction import Prediction
from incsvr.learning.several_velocities.drag import Drag
from incsvr.learning.velocities import distances, points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

if TYPE_CHECKING:
    from incsvr.learning.model import Model

OUTSIDE_DISTANCES = 1.25
"""Distances from the nearest vector, in usual ones between neighbouring vectors, from which on a velocity lies outside
the driven cloud. On six simulated vehicles over three velocities the
error outside is 3.6 times that inside after four batches and 2.2 times after twenty; at 2 the worst corners count as
driven."""
USUAL_DISTANCE_QUANTILE = 0.75
"""Quantile of the distances from each vector to its nearest that is their usual distance."""
MAX_MAGNITUDE = 1e30
"""Size below which every velocity and every force is: nothing physical is as large, and no product of two overflows."""
MIN_DISTANCE_SHARE = 0.02
"""Least of that distance, as a part of the fastest velocities: vectors that lie on each other are one place."""


@dataclass(frozen=True, eq=False)
class Several:
    """The further velocities of a model."""

    own: str  # the axis's own velocity, as recordings call it
    others: tuple[str, ...]  # their names; those of channels
    velocity: Array  # (m, d) of each vector, the own one first, in their units
    fastest: Array  # (d,) by which each is scaled, in its unit
    drag: Array  # (p,) coefficients of the textbook's drag [N m] (`terms`)

    def terms(self, u: Array) -> Array:
        """(n, p) terms of the drag at (n, d) scaled velocities."""
        return self._form.terms(u)

    @cached_property
    def _form(self) -> Drag:
        return Drag.of(self.own, self.others)

    @cached_property
    def _vectors(self) -> Array:
        """(m, d) as the kernel has them."""
        return self.scaled(self.velocity)[1]

    @cached_property
    def _limit(self) -> Array:
        """(d,) how fast each velocity may be in an answer."""
        return np.concatenate(([np.inf], np.abs(self.velocity[:, 1:]).max(axis=0, initial=0.0)))

    @property
    def usual(self) -> Array:
        """(d − 1,) the others' median over the vectors: where a question names the own velocity alone."""
        return np.asarray(np.median(self.velocity[:, 1:], axis=0))

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest learned value of each further velocity; none where the drag alone explains everything."""
        columns = self.velocity[:, 1:].T
        if not columns.size:
            return {}
        return {name: (float(c.min()), float(c.max())) for name, c in zip(self.others, columns, strict=True)}

    def at(self, samples: Samples) -> Array:
        """(n, d) the velocities of samples."""
        return points(samples, self.others)

    def beside(self, rate: Array) -> Array:
        """(n, d) own velocities (n,), each with the usual others."""
        return np.column_stack((rate, np.broadcast_to(self.usual, (rate.size, len(self.others)))))

    def scaled(self, velocity: Array) -> tuple[Array, Array]:
        """(n, d) velocities with 1 as the fastest, and as the kernel has them: in the unit of the own one."""
        u = velocity / self.fastest
        return u, u * self.fastest[0]

    def within(self, velocity: Array) -> Array:
        """(n, d) velocities of which the others stay as fast as the fastest vector where they are faster.

        A product of velocities of which the vectors tell little would grow without bound; the own drag may.
        """
        return np.asarray(np.minimum(np.maximum(velocity, -self._limit), self._limit))

    def value(self, velocity: Array, gamma: float, weight: Array) -> Array:
        """(n,) damping at (n, d) velocities [N m]: the drag, and the sum of kernels that has the rest."""
        u, z = self.scaled(self.within(velocity))
        return np.asarray(self.terms(u) @ self.drag + rbf_at_rest(z, self._vectors, gamma) @ weight)

    def derivative(self, velocity: Array, gamma: float, weight: Array) -> Array:
        """(n,) ∂d/∂ν₁ of `value` with respect to the own velocity, at (n, d) velocities [N m s/rad]."""
        u, z = self.scaled(self.within(velocity))
        kernels = rbf_at_rest_slope(z, self._vectors, gamma) @ weight
        return np.asarray(self._form.slopes(u) @ self.drag / self.fastest[0] + kernels)

    def possible(self, rate: Array) -> bool:
        """Whether every number is one that learning can have led to, beside vectors of these own velocities (m,)."""
        shape = (rate.size, 1 + len(self.others))
        numbers = np.concatenate((self.velocity.ravel(), self.fastest, self.drag))
        return (
            self.velocity.shape == shape
            and self.fastest.shape == shape[1:]
            and self.drag.shape == self.terms(np.zeros((1, shape[1])))[0].shape
            and bool((np.abs(numbers) < MAX_MAGNITUDE).all() and (self.fastest > 0.0).all())
            and bool((self.velocity[:, 0] == rate).all())
        )


@dataclass(frozen=True, eq=False)
class Surface:
    """A model over several velocities made ready for questions."""

    model: Model  # the model
    several: Several  # its further velocities
    columns: Pivots  # of the kernel
    scale: float  # of what the kernels hold, the largest that the drag leaves over at a vector [N m]
    largest: float  # the largest damping of the vectors, the prior of each term of the drag [N m]
    doubt: Doubt  # of the surface
    reach: float  # distance from the nearest vector beyond which nothing was driven, in fastest velocities

    @staticmethod
    def of(model: Model) -> Surface:
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
