"""Damping that drifts."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class DragDrift(Effect):
    """d(r) grows by the factor 1 + f (t − t₀)/(t₁ − t₀) over the fitted recordings."""

    name = "drag_drift"
    sentence = "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} drifts over the recording, as with fouling"
    source = "M. P. Schultz, Biofouling 23(5), 2007 (drag of fouled hulls)"
    equation = "I ṙ + d(r) (1 + f p) = τ, p from 0 to 1 over the recordings"
    shown_by = "the same {rates} early and late in the recordings"
    acts = "damping"
    needs_clock = True
    parameter_names = ("fraction",)

    def small(self, s: Signals, term: Term) -> float:
        return 0.02

    def implausible(self, term: Term, s: Signals) -> str:
        fraction = term.coefficients[0]
        return f"the damping would change by {fraction:.0%}" if not -0.9 < fraction < 5.0 else ""

    def factor(self, s: Signals, term: Term) -> Array:
        return np.maximum(1.0 + term.coefficients[0] * s.progress, 0.05)
