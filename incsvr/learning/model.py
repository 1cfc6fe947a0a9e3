"""The served model: the damping curve f(r) = Σ θⱼ κ(rⱼ, r), its uncertainty, and its extrapolation by physics.

One formula says how sure. With the columns ψ of the model, those of its kernel and of the drag beside it, scaled by the
largest damping, the curve is a Gaussian process (Rasmussen and Williams, 2006, Section 2.7) whose vectors have as much
noise as their samples leave, D; and a part of a sample's own deviation σ(r) is common to all samples of a rate:

    doubt² = ψᵀ(I + Ψ D⁻¹ Ψᵀ)⁻¹ψ + what the columns leave out of the kernel + (SYSTEMATIC_NOISES σ(r))² + (slope r)²

Nothing in it cancels. Regression errs in the slope by m s/(s² + R²) where the water makes motion of mean square s² with
moments of deviation m, and what was learned moves by R².
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import exp, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from incsvr.errors import BadInput
from incsvr.learning.drag import Several, distances
from incsvr.learning.excitation import Water
from incsvr.learning.kernel import Pivots, Series, rbf
from incsvr.learning.noise import Spread
from incsvr.learning.prediction import Continuation, Prediction
from incsvr.numerics import Array, independent_part, lapack
from incsvr.numerics.plain import fields_from_plain, fields_to_plain
from incsvr.signals.samples import Samples

SYSTEMATIC_NOISES = 0.35
"""Doubt that no number of samples takes away, in noise levels: between two samples torque and water are not known, and
the curve is as smooth as its kernel."""
NOISE_SHARE = sqrt(1.0 - SYSTEMATIC_NOISES**2)
"""The noise as a part of what fresh samples leave over, which holds the systematic doubt as well."""
SAMPLES_PER_INDEPENDENT = 1.7
"""Samples that tell as much as one, beyond what their correlation and the loss take: water lasts longer than it shows
from one sample to the next. Fitted with SYSTEMATIC_NOISES to 89 missions of twelve kinds (seeds 910000 on): there
the weighted policy's band of 95 % holds the truth at 95 % of the rates, of surveys at 84 %; the paper's at 99 %."""
WATER_FACTOR = 1.5
"""Factor by which the water stands in what was learned beside what it would at random: motion counts as driven where
its work is clear, and the water may have helped it."""
MIN_NOISE_SHARE = 1e-6
"""Noise of a vector over the largest damping, at least: nothing is divided by zero."""
MAX_GAP_LENGTHS = 0.5
"""Distance from the nearest vector beyond which a rate between vectors is not learned either, in lengths 1/√γ."""
OUTSIDE_DISTANCES = 1.25
"""Distances from the nearest vector, in usual ones between neighbouring vectors (their quantile of 0.75), from which on
several velocities lie outside the driven cloud. On six simulated vehicles over three velocities the error outside is
3.6 times that inside after four batches and 2.2 times after twenty; at 2 the worst corners count as driven."""
MIN_DISTANCE_SHARE = 0.02
"""Least of that distance, as a part of the fastest velocities: vectors that lie on each other are one place."""


@dataclass(frozen=True, eq=False)
class Model:
    """The ε-SVR without bias (no drag acts on a vehicle at rest), f(r) = Σ θⱼ κ(rⱼ, r) with θ = α − β."""

    gamma: float  # kernel width γ [(rad/s)⁻²] of κ(x, z) = exp(−γ(x − z)²)
    C: float  # bound on |θ| [N m] and half height of the tube [N m], as configured
    epsilon: float
    support_rate: Array  # (m,) the vectors [rad/s], [N m] and their θ [N m]
    support_damping: Array
    weight: Array
    count: Array  # (m,) how many samples each vector stands for
    sigma: float  # noise level of a damping sample [N m], over all rates
    certified_error: float  # no exact solution differs from this one by more, at any rate [N m]
    correlation: float = 0.0  # of the noise of two samples that follow each other
    water: Water = field(default_factory=Water)  # the motion that was no evidence, because the water made it
    spread: Spread = field(default_factory=lambda: Spread(1.0))  # how the noise follows the yaw rate
    # the further velocities that damping was learned over; None where it was over the own one alone
    several: Several | None = None

    @staticmethod
    def untrained(gamma: float, C: float, epsilon: float) -> Model:
        nothing = np.empty(0)
        return Model(gamma, C, epsilon, nothing, nothing, nothing, nothing, sigma=float("nan"), certified_error=0.0)

    @property
    def is_trained(self) -> bool:
        return self.support_rate.size > 0

    @property
    def trained_range(self) -> tuple[float, float] | None:
        """Lowest and highest learned rate [rad/s]; None before anything is learned."""
        if not self.is_trained:
            return None
        return float(self.support_rate.min()), float(self.support_rate.max())

    @property
    def others_at_support(self) -> dict[str, Array]:
        """The further velocities of the vectors, by name; none of a model over one."""
        if self.several is None:
            return {}
        return dict(zip(self.several.others, self.several.velocity[:, 1:].T, strict=True))

    def evaluate(self, rate: Array) -> Array:
        """The bare sum f(rate) [N m] at (n,) rates, without continuation: what training compares samples with."""
        return rbf(rate, self.support_rate, self.gamma) @ self.weight

    def learned(self, samples: Samples) -> Array:
        """The values that training compares (n,) samples with, at their velocities [N m]."""
        if self.several is None:
            return self.evaluate(samples.yaw_rate)
        return self.several.value(self.several.at(samples), self.gamma, self.weight)

    def served(self, samples: Samples, learned: Array) -> Array:
        """The damping that `at` answers, without its doubt (n,) [N m], where the values of `learned` are known."""
        low, high = self.trained_range or (0.0, 0.0)
        rate = samples.yaw_rate
        if self.several is None and not (low <= float(rate.min()) and float(rate.max()) <= high):
            return self.predict(rate).damping
        return learned

    def predict(self, rate: ArrayLike) -> Prediction:
        """Damping, its uncertainty and whether it is extrapolated at (n,) rates, or one [rad/s].

        Of a model over several velocities it is a slice: the others are as usual where it learned.

        Raises:
            BadInput: nothing is learned yet, or a rate is not finite.
        """
        rates = np.array(rate, dtype=np.float64, ndmin=1)
        if self.several is None:
            return self._trained.over_one(rates)
        return self._trained.over_several(self.several.beside(rates))

    def one(self, rate: float) -> tuple[float, float, bool, float, float] | None:
        """Damping, sigma, extrapolated, noise and derivative at one learned rate [rad/s]; None where only `predict`
        answers: where nothing is learned, outside the learned range, and of a model over several velocities."""
        if self.several is not None or not self.is_trained:
            return None
        answers = self._answers
        low, high = answers.ends
        return answers.one(rate) if low <= rate <= high else None

    def at(self, samples: Samples) -> Prediction:
        """The prediction at the velocities of (n,) samples."""
        if self.several is None:
            return self.predict(samples.yaw_rate)
        return self.over(self.several.at(samples))

    def over(self, velocity: Array) -> Prediction:
        """The prediction at (n, d) velocities, the own one first, of a model over several.

        Raises:
            BadInput: nothing is learned yet, or a velocity is not finite.
        """
        return self._trained.over_several(velocity)

    @property
    def _trained(self) -> Answers:
        if not self.is_trained:
            raise BadInput("nothing is learned yet; ask again after the first iteration")
        return self._answers

    def to_dict(self) -> dict[str, Any]:
        """Plain data, exact to the bit through JSON."""
        return fields_to_plain(self) | {"sigma": self.sigma if self.is_trained else None}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Model:
        sigma = data["sigma"]
        known = fields_from_plain(Model, {**data, "sigma": 0.0 if sigma is None else sigma})
        return replace(known, sigma=math.nan) if sigma is None else known

    @cached_property
    def _answers(self) -> Answers:
        return Answers.of(self)


@dataclass(frozen=True, eq=False)
class Answers:
    """A trained model made ready for questions: products with its columns."""

    model: Model
    columns: Series | Pivots  # of the kernel
    phi: Array  # (rank, m) φ at the vectors
    largest: float  # the largest damping of the vectors, the scale of each term of the drag [N m]
    scale: float  # of what the kernels hold [N m]: the same, over several velocities what the drag leaves over
    variance: Array  # (m,) of the vectors, D [N² m²]
    factor: Array  # Cholesky factor of I + Ψ D⁻¹ Ψᵀ

    @staticmethod
    def of(model: Model) -> Answers:
        several, rate, damping = model.several, model.support_rate, model.support_damping
        scale = largest = max(float(np.abs(damping).max()), 1e-9)
        noise = np.maximum(model.sigma * model.spread.at(rate), MIN_NOISE_SHARE * largest)
        # the loss |e| of an SVR takes π/2 times as many samples as least squares
        worth = independent_part(model.correlation) * 2.0 / (pi * SAMPLES_PER_INDEPENDENT)
        variance = noise**2 / (worth * model.count)
        if several is None:
            series = Series.over(float(rate.min()), float(rate.max()), model.gamma)
            columns, phi = Pivots.of(rate, model.gamma, False) if series is None else (series, series.at(rate))
            psi = scale * phi
        else:
            u, z = several.scaled(several.velocity)
            terms = several.terms(u).T
            scale = max(float(np.abs(damping - several.drag @ terms).max()), float(noise.max()))
            columns, phi = Pivots.of(z, model.gamma, True)
            psi = np.concatenate((largest * terms, scale * phi))
        normal = np.dot(psi / variance, psi.T)
        normal.reshape(-1)[:: normal.shape[0] + 1] += 1.0
        return Answers(model, columns, phi, largest, scale, variance, lapack.cholesky(normal))

    def over_one(self, rate: Array) -> Prediction:
        """The prediction of a model over one velocity at (n,) rates [rad/s].

        Raises:
            BadInput: a rate is not finite.
        """
        low, high = self.ends
        if rate.size == 1 and low <= (one := float(rate[0])) <= high:
            return Prediction(*(np.array((value,)) for value in self.one(one)))
        inside = np.minimum(np.maximum(rate, low), high)
        outside = inside != rate
        beyond = bool(outside.any())
        if beyond and not np.isfinite(rate).all():
            raise BadInput("a rate is not finite; give numbers in rad/s")
        model, columns, phi, left = self.model, self.columns, self.columns.at(inside), 0.0
        if isinstance(columns, Series):
            damping, slope = self.weights.dot(phi)
            derivative = slope - 2.0 * model.gamma * (inside - columns.centre) * damping
        else:
            kernel = rbf(inside, model.support_rate, model.gamma)
            damping = kernel @ model.weight
            derivative = 2.0 * model.gamma * (kernel @ (model.weight * model.support_rate) - inside * damping)
            left = self.scale**2 * np.maximum(1.0 - np.add.reduce(phi * phi, axis=0), 0.0)
        doubt = self._doubt(rate, self.scale * phi, left)
        if beyond:
            ends = (values[outside] for values in (rate, inside, damping, doubt))
            damping[outside], derivative[outside], doubt[outside] = self._beyond.predict(*ends)
        if self._gaps:
            ordered, edges, reach = self._gaps
            outside |= np.abs(inside - ordered[edges.searchsorted(inside)]) > reach
        return self._said(rate, damping, doubt, outside, derivative)

    def over_several(self, velocity: Array) -> Prediction:
        """The prediction of a model over several velocities at (n, d) of them in their units.

        Its doubt is small among the vectors, and the drag's own far from them.

        Raises:
            BadInput: a velocity is not finite.
        """
        if not np.isfinite(velocity).all():
            raise BadInput("a velocity is not finite; give numbers in m/s and rad/s")
        model, several, own = self.model, self.model.several, velocity[:, 0]
        assert several is not None
        u, z = several.scaled(velocity)
        phi = self.columns.at(z)
        at_rest = np.exp(-2.0 * model.gamma * np.sum(z * z, axis=1))
        left = self.scale**2 * np.maximum(1.0 - at_rest - np.add.reduce(phi * phi, axis=0), 0.0)
        doubt = self._doubt(own, np.concatenate((self.largest * several.terms(u).T, self.scale * phi)), left)
        outside = distances(u, several.velocity / several.fastest).min(axis=1) > self._reach
        value, derivative = (of(velocity, model.gamma, model.weight) for of in (several.value, several.derivative))
        return self._said(own, value, doubt, outside, derivative)

    def _doubt(self, rate: Array, psi: Array, left: Array | float = 0.0) -> Array:
        """(n,) standard deviation of the curve [N m] at rates with columns psi (r, n) [N m] that leave out `left`."""
        systematic = SYSTEMATIC_NOISES * self.model.sigma * self.model.spread.at(rate)
        variance = np.add.reduce(psi * lapack.dpotrs(self.factor, psi)[0], axis=0) + left
        return np.asarray(np.sqrt(variance + systematic * systematic + (self._slope * rate) ** 2))

    def _said(
        self, rate: Array, damping: Array, doubt: Array, outside: NDArray[np.bool_], derivative: Array
    ) -> Prediction:
        noise = np.asarray(NOISE_SHARE * self.model.sigma * self.model.spread.at(rate))
        return Prediction(damping, np.hypot(noise, doubt), outside, noise, derivative)

    @cached_property
    def _slope(self) -> float:
        """The largest error of the slope where the water moved the vehicle [N m s/rad]."""
        water, count = self.model.water, self.model.count
        learned = float(count @ self.model.support_rate**2) / float(count.sum())
        return WATER_FACTOR * sqrt(water.moment * water.rate) / max(water.rate + learned, 1e-300)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """The lowest and the highest learned rate [rad/s]."""
        return float(self.model.support_rate.min()), float(self.model.support_rate.max())

    @cached_property
    def weights(self) -> Array:
        """(2, rank) w = Φθ, f = wᵀφ, and the weights of the slope, f' = w'ᵀφ − 2γ(x − centre) f, of a series."""
        w = np.zeros((2, self.phi.shape[0]))
        w[0] = self.phi.dot(self.model.weight)
        w[1, :-1] = np.sqrt(2.0 * self.model.gamma * np.arange(1.0, w.shape[1])) * w[0, 1:]
        return w

    @cached_property
    def _reach(self) -> float:
        """The reach of the cloud of vectors beyond each of them, in fastest velocities."""
        assert self.model.several is not None
        u = self.model.several.velocity / self.model.several.fastest
        if u.shape[0] < 2:
            return MIN_DISTANCE_SHARE
        apart = distances(u, u)
        np.fill_diagonal(apart, np.inf)
        return OUTSIDE_DISTANCES * max(float(np.quantile(apart.min(axis=1), 0.75)), MIN_DISTANCE_SHARE)

    @cached_property
    def _gaps(self) -> tuple[Array, Array, float] | None:
        """The vectors' rates in order, the middles between them, and how far from them is learned [rad/s]; None where
        every rate within the range is near one."""
        ordered, reach = np.sort(self.model.support_rate), MAX_GAP_LENGTHS / sqrt(self.model.gamma)
        edges = 0.5 * (ordered[1:] + ordered[:-1])
        return (ordered, edges, reach) if (np.diff(ordered) > 2.0 * reach).any() else None

    @cached_property
    def _beyond(self) -> Continuation:
        return Continuation.fit(self.model.support_rate, self.weights[0].dot(self.phi), 1.0 / self.variance)

    @cached_property
    def one(self) -> Callable[[float], tuple[float, float, bool, float, float]]:
        """Damping, sigma, extrapolated, noise and derivative at one learned rate [rad/s], as plain numbers.

        Questions for one rate are frequent, and the calls of NumPy cost ten times its arithmetic: on a short series all
        three sums are polynomials of u = x − centre times exp(−γu²), or its square.
        """
        columns, model = self.columns, self.model
        if not isinstance(columns, Series):

            def by_columns(rate: float) -> tuple[float, float, bool, float, float]:
                found = self.over_one(np.array((rate, rate)))
                return (
                    *(float(found.damping[0]), float(found.sigma[0]), bool(found.extrapolated[0])),
                    *(float(found.noise[0]), float(found.derivative[0])),
                )

            return by_columns
        gamma, centre, powers = columns.gamma, columns.centre, np.cumprod(np.append(1.0, columns.factors))
        rank = powers.size
        inverse = lapack.dpotrs(self.factor, np.eye(rank))[0] * np.multiply.outer(powers, powers) * self.scale**2
        variances = np.bincount(np.add.outer(np.arange(rank), np.arange(rank)).ravel(), inverse.ravel())[::-1].tolist()
        curve = list(zip(*(self.weights * powers)[:, ::-1].tolist(), strict=True))
        level, knots, fastest = model.sigma**2, model.spread.variance, model.spread.fastest
        last, gaps, slope_by_water = len(knots) - 1, self._gaps, self._slope
        ordered, edges, reach = ([], [], 0.0) if gaps is None else (gaps[0].tolist(), gaps[1].tolist(), gaps[2])

        def at(rate: float) -> tuple[float, float, bool, float, float]:
            u = rate - centre
            kernel = exp(-gamma * u * u)
            f = slope = variance = 0.0
            for of_f, of_slope in curve:
                f, slope = f * u + of_f, slope * u + of_slope
            for each in variances:
                variance = variance * u + each
            f, slope, variance = f * kernel, slope * kernel, variance * kernel * kernel
            far = bool(ordered) and abs(rate - ordered[bisect(edges, rate)]) > reach
            place = min(abs(rate) / fastest, 1.0) * last
            knot = min(int(place), last - 1)
            own = level * (knots[knot] + (place - knot) * (knots[knot + 1] - knots[knot]))
            sigma = sqrt(max(variance, 0.0) + own + (slope_by_water * rate) ** 2)
            return f, sigma, far, NOISE_SHARE * sqrt(own), slope - 2.0 * gamma * u * f

        return at
