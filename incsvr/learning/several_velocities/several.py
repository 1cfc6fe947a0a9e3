"""The further velocities of a model, and its surface over them: the drag, and the kernels that vanish at rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from incsvr.learning.kernel import rbf_at_rest, rbf_at_rest_slope
from incsvr.learning.several_velocities.drag import Drag
from incsvr.learning.velocities import points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MAX_MAGNITUDE = 1e30
"""Size below which every velocity and every force is: nothing physical is as large, and no product of two overflows."""


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
