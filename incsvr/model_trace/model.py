"""The model with its effects as one value, which is saved and read.

I₀ ṙ + d(r) + Σ effects = τ
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from incsvr.numerics import Array

TABLE_RATES = 101
"""Rates of the table to either side."""


@dataclass(frozen=True, slots=True)
class Term:
    """An effect as it is in a model.

    Attributes:
        effect: its name in the catalogue, with the channel if it has one.
        variant: which form of the effect (see `Effect.variant`).
        coefficients: θ, one for each column; one for an effect on thrust or damping.
        inner: the parameters that are searched; a shape, if any, first, and the size that the effect is known by last.
    """

    effect: str
    variant: str
    coefficients: tuple[float, ...]
    inner: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class TracedModel:
    """The declared model, its learned damping and the effects that were added.

    Attributes:
        inertia: I₀, as declared [kg m²].
        rate: (m,) increasing rates of the damping table [rad/s]; the trained range.
        damping: (m,) d(r) there [N m].
        terms: the effects with their values.
        sigma: deviation of a block residual [N m].
        block: the length of such a block [s].
        scale: T_c, the time scale of the vehicle's motion [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
        offset: by how much the torque acts later than these recordings stamped it, within a sample [s].
    """

    inertia: float
    rate: Array
    damping: Array
    terms: tuple[Term, ...]
    sigma: float
    block: float
    scale: float
    origin: tuple[float, float]
    offset: float = 0.0

    def damping_at(self, rate: Array) -> Array:
        """d(r) [N m]; beyond the trained range the edge's drag continues quadratically."""
        inside = np.interp(rate, self.rate, self.damping)
        edge = np.where(rate > 0.0, self.rate[-1], self.rate[0])
        beyond = np.maximum(np.abs(rate / np.where(edge == 0.0, 1.0, edge)), 1.0)
        continued: Array = inside * beyond**2
        return continued

    def to_dict(self) -> dict[str, Any]:
        """Plain data, exact to the last bit through JSON."""
        data = asdict(self)
        data["rate"], data["damping"] = self.rate.tolist(), self.damping.tolist()
        return data

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TracedModel:
        terms = tuple(
            Term(t["effect"], t["variant"], tuple(t["coefficients"]), tuple(t["inner"])) for t in data["terms"]
        )
        low, high = data["origin"]
        return TracedModel(
            data["inertia"], np.array(data["rate"]), np.array(data["damping"]), terms,
            data["sigma"], data["block"], data["scale"], (low, high), data.get("offset", 0.0),
        )  # fmt: skip
