"""The served model: the damping curve f(r) = Σ θⱼ κ(rⱼ, r), its uncertainty, and its extrapolation by physics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.learning.kernel import rbf
from incsvr.learning.prediction import Curve, Prediction
from incsvr.learning.several_velocities.surface import Surface
from incsvr.learning.support import Support
from incsvr.numerics import Array
from incsvr.numerics.plain import fields_from_plain, fields_to_plain
from incsvr.signals.samples import Samples


@dataclass(frozen=True, eq=False)
class Model(Support):
    """The ε-SVR without bias (no drag acts on a vehicle at rest), f(r) = Σ θⱼ κ(rⱼ, r) with θ = α − β."""

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

    @property
    def at_support(self) -> Array:
        """(m,) the bare sum f at the vectors [N m]."""
        return self._curve.at_vectors

    def evaluate(self, rate: Array) -> Array:
        """The bare sum f(rate) [N m] at (n,) rates, without continuation: what training compares samples with."""
        return rbf(rate, self.support_rate, self.gamma) @ self.weight

    def learned(self, samples: Samples) -> Array:
        """The values that training compares (n,) samples with, at their velocities [N m]."""
        if self.several is None:
            return self.evaluate(samples.yaw_rate)
        return self.several.value(self.several.at(samples), self.gamma, self.weight)

    def predict(self, rate: ArrayLike) -> Prediction:
        """Damping, its uncertainty and whether it is extrapolated at (n,) rates, or one [rad/s].

        Of a model over several velocities it is a slice: the others are as usual where it learned.

        Raises:
            BadInput: nothing is learned yet, or a rate is not finite.
        """
        self._must_be_trained()
        rates = np.array(rate, dtype=np.float64, ndmin=1)
        if self.several is None:
            return self._curve.predict(rates)
        return self._surface.predict(self.several.beside(rates))

    def one(self, rate: float) -> tuple[float, float, bool, float, float] | None:
        """Damping, sigma, extrapolated, noise and derivative at one learned rate [rad/s]; None where only `predict`
        answers: where nothing is learned, outside the learned range, and of a model over several velocities."""
        if self.several is not None or not self.is_trained:
            return None
        curve = self._curve
        one = curve.one
        return one(rate) if curve.low <= rate <= curve.high else None

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
        self._must_be_trained()
        return self._surface.predict(velocity)

    def _must_be_trained(self) -> None:
        if not self.is_trained:
            raise BadInput("nothing is learned yet; ask again after the first iteration")

    def to_dict(self) -> dict[str, Any]:
        """Plain data, exact to the bit through JSON."""
        return fields_to_plain(self) | {"sigma": self.sigma if self.is_trained else None}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Model:
        return fields_from_plain(Model, {**data, "sigma": math.nan if data["sigma"] is None else data["sigma"]})

    @cached_property
    def _surface(self) -> Surface:
        return Surface.of(self)

    @cached_property
    def _curve(self) -> Curve:
        return Curve.of(self)
