"""The textbook's drag of several velocities, to which the sum of kernels is what it lacks.

Fossen (2011, Section 6.4) writes damping to second order as N_i νᵢ + N_{i|j|} νᵢ|νⱼ|; beside it stand the products νᵢνⱼ
that lift and Munk's moment make where no mass matrix takes them out. A sum of kernels falls back to zero where nothing
was learned, and on a few dozen vectors in two or three dimensions that is close to everywhere. The kernels therefore
learn what this drag leaves over (a semiparametric SVR: Smola, Frieß and Schölkopf, NIPS 1998), and the drag alone is
what goes on outside. It is zero at rest.

A hull whose port is the mirror of its starboard knows which terms there are (Fossen 2011, Eq. 7.22): mirrored, sway,
roll and yaw change their signs and so do the forces along them, and surge, heave and pitch do not. What a vehicle that
is not its own mirror has beside them is left to the kernels.

One γ and one nearness serve for all velocities: every other one is multiplied until its fastest value is as far from
rest as the fastest own one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np

from incsvr.learning.kernel import rbf_at_rest, rbf_at_rest_slope
from incsvr.numerics import Array
from incsvr.plant.axes import BODY_YAW_RATE, LATERAL
from incsvr.signals.samples import Samples

PRIOR_NOISE_SHARE = 0.1
"""Noise of a sample over the largest moment, before anything is known of it."""
HUBER_DEVIATIONS = 2.0
"""Median deviations up to which a sample counts by its square: 1.35 standard deviations of normal noise, where Huber's
regression loses a twentieth of what least squares know."""
MIN_C_SHARE = 1e-6
"""Share of C that is left at least: where the drag explains everything, nothing is divided by zero."""
TAMING_ROUNDS = 5
"""Rounds in which the weights are told anew."""
MAX_MAGNITUDE = 1e30
"""Size below which every velocity and every force is: nothing physical is as large, and no product of two overflows."""


def points(samples: Samples, others: Sequence[str]) -> Array:
    """(n, d) the own velocity and the others, in their units."""
    if not others:
        return samples.yaw_rate[:, None]
    return np.column_stack((samples.yaw_rate, *(samples.channels[name] for name in others)))


def distances(x: Array, z: Array) -> Array:
    """(n, m) between (n, d) and (m, d) scaled velocities."""
    if x.shape[1] == 1:
        return np.asarray(np.abs(x - z[:, 0]))
    square = np.zeros((x.shape[0], z.shape[0]))
    for x_k, z_k in zip(x.T, z.T, strict=True):
        difference = np.subtract.outer(x_k, z_k)
        difference *= difference
        square += difference
    return np.asarray(np.sqrt(square))


@dataclass(frozen=True, slots=True)
class Drag:
    """The terms of the drag of one axis, from velocities i and j of which the own one is 0."""

    linear: tuple[int, ...]  # i of νᵢ
    sizes: tuple[tuple[int, int], ...]  # (i, j) of νᵢ|νⱼ|, those of i = j first
    products: tuple[tuple[int, int], ...]  # (i, j), i ≤ j, of νᵢνⱼ

    @staticmethod
    def of(own: str, others: Sequence[str]) -> Drag:
        """The drag of an axis whose own velocity has this name, over it and the others."""
        lateral = [name in LATERAL or name == BODY_YAW_RATE for name in (own, *others)]
        alike, all_of = [i for i, side in enumerate(lateral) if side == lateral[0]], range(len(lateral))
        return Drag(
            tuple(alike),
            tuple([(i, i) for i in alike] + [(i, j) for i in alike for j in all_of if i != j]),
            # a product keeps its sign where both or neither do; ν₁² is no drag
            tuple(
                (i, j)
                for i, j in combinations_with_replacement(all_of, 2)
                if (lateral[i] != lateral[j]) == lateral[0] and (i, j) != (0, 0)
            ),
        )

    def terms(self, u: Array) -> Array:
        """(n, p) at (n, d) velocities; those of u/f are these over those of f, for any positive f (d,)."""
        columns = [u[:, i] for i in self.linear] + [u[:, i] * np.abs(u[:, j]) for i, j in self.sizes]
        return np.stack(columns + [u[:, i] * u[:, j] for i, j in self.products], axis=1)

    def slopes(self, u: Array) -> Array:
        """(n, p) derivatives of the terms with respect to the own scaled velocity."""
        sign = np.sign(u[:, 0])
        columns = [np.full(len(u), float(i == 0)) for i in self.linear]
        columns += [(i == 0) * np.abs(u[:, j]) + (j == 0) * u[:, i] * sign for i, j in self.sizes]
        return np.stack(columns + [(i == 0) * u[:, j] for i, j in self.products], axis=1)

    @property
    def damps(self) -> Array:
        """(p,) 1 for the terms that damp the own velocity whatever the others do, ν₁, ν₁|ν₁| and ν₁|νⱼ|; 0 else."""
        own = [i == 0 for i in self.linear] + [i == 0 for i, _ in self.sizes]
        return np.array(own + [False] * len(self.products), dtype=np.float64)


def fitted(phi: Array, damping: Array, count: Array, sigma: float) -> Array:
    """(p,) coefficients [N m] by Huber's regression, with a prior that decides what the samples leave open.

    The prior is wide: each term alone may reach the largest moment.

    Args:
        phi: (n, p) terms of velocities that are scaled so that the fastest is 1, n ≥ 1.
        damping: (n,) [N m].
        count: (n,) how many samples each stands for.
        sigma: noise of one sample, were it independent of the others [N m]; NaN where nobody knows it yet.
    """
    if not damping.any():
        return np.zeros(phi.shape[1])
    largest = float(np.abs(damping).max())
    noise = PRIOR_NOISE_SHARE if np.isnan(sigma) else max(sigma / largest, 1e-6)
    prior = noise**2 * np.eye(phi.shape[1])
    weight = count
    best: Array = np.zeros(phi.shape[1])
    for _ in range(TAMING_ROUNDS):
        pull = (phi * weight[:, None]).T
        best = np.asarray(np.linalg.solve(pull @ phi + prior, pull @ damping), dtype=np.float64)
        left = np.abs(damping - phi @ best)
        level = max(HUBER_DEVIATIONS * float(np.median(left)), 1e-6 * largest)
        weight = count * level / np.maximum(left, level)
    return best


def share_left(damping: Array, left: Array, count: Array, sigma: float) -> float:
    """The factor on C for the remainder of the drag: its share of the power, without noise,
    MIN_C_SHARE to 1.

    Where the loss is |e| and a function is as large as s, the best C is s² over the noise (the Laplace density beside a
    Gaussian process of variance s²). The configured C is one for the whole damping.

    Args:
        damping, left: (n,) [N m], n ≥ 1.
        count: (n,) how many samples each stands for.
        sigma: noise of one sample [N m]; NaN where nobody knows it yet.
    """
    noise = 0.0 if np.isnan(sigma) else count.size * sigma**2
    whole = float(count @ damping**2) - noise
    return min(max((float(count @ left**2) - noise) / whole, MIN_C_SHARE), 1.0) if whole > 0.0 else 1.0


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
