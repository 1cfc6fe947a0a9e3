"""A smooth term of one channel: no physics, an honest name for what is seen but not explained."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Array, Signals

INTERVALS = 4
"""Of the cubic spline."""


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
        self.core = INTERVALS + 2

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        values = self._values(s)
        low, high = (float(q) for q in np.quantile(values, [0.002, 0.998]))
        return [(low, high)] if high > low else []

    def _values(self, s: Signals) -> Array:
        if self._channel == "time":
            return s.time
        if self._channel == "heading":
            turned: Array = np.mod(s.heading, 2.0 * np.pi)
            return turned
        return s.channels[self._channel]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        low, high = inner
        knots = np.concatenate([[low] * 3, np.linspace(low, high, INTERVALS + 1), [high] * 3])
        basis = BSpline.design_matrix(np.clip(self._values(s), low, high), knots, 3).toarray()
        # the spline without its constant first, its constant last: the level alone is a bias, not this channel's doing
        columns: Array = np.column_stack([-(basis[:, 1:] - basis[:, :1]), -np.ones(basis.shape[0])])
        return columns

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {}
