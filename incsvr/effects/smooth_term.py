"""A smooth term of one channel: no physics, an honest name for what is seen but not explained."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

SPLINE_INTERVALS = 4
"""Intervals of the cubic spline."""


class SmoothTerm(Effect):
    """−s(x), a cubic spline of a channel, of time or of heading; reported as unexplained, never as an effect."""

    sentence = "the residual follows this channel, but no effect of the catalogue does"
    source = "S. N. Wood, Generalized Additive Models, 2017 (smooth terms)"

    def __init__(self, channel: str) -> None:
        self.name = f"unexplained:{channel}"
        self.channels = (channel,) if channel not in ("time", "heading") else ()
        self.needs_clock = channel == "time"
        self._channel = channel
        self.acts = "motion" if channel == "heading" else "outside"

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        """Knots at quantiles: every interval holds data."""
        knots = tuple(float(q) for q in np.quantile(self._values(s), [0.01, 0.25, 0.5, 0.75, 0.99]))
        return [knots] if np.all(np.diff(knots) > 1e-9 * (knots[-1] - knots[0])) else []

    def _values(self, s: Signals) -> Array:
        if self._channel == "time":
            return s.time
        if self._channel == "heading":
            wrapped: Array = np.mod(s.heading, 2.0 * np.pi)
            return wrapped
        return s.channels[self._channel]

    def width(self, inner: tuple[float, ...]) -> int:
        return SPLINE_INTERVALS + 3

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])
        values = np.clip(self._values(s), inner[0], inner[-1])
        basis = BSpline.design_matrix(values, knots, 3).toarray()
        middle = BSpline.design_matrix(np.array([inner[len(inner) // 2]]), knots, 3).toarray()
        # zero at the median, the constant last: the level alone is a bias, not this channel's doing
        columns: Array = np.column_stack([-(basis - middle)[:, 1:], -np.ones(basis.shape[0])])
        return columns

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {}
