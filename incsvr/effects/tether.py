"""The twist of a tether."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Tether(Effect):
    """I ṙ + d(r) + k (ψ − ψ₀) = τ; the second column places the neutral angle ψ₀."""

    name = "tether"
    sentence = "a tether turns the vehicle back with a moment that grows with the turned angle"
    source = "F. Dukan, M. Ludvigsen, A. J. Sørensen, OCEANS 2011 (ROV with umbilical)"
    acts = "motion"

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(s.heading, np.ones_like(s.heading))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        stiffness, moment = term.coefficients
        return {"stiffness_nm_per_rad": stiffness, "neutral_rad": -moment / stiffness if stiffness else 0.0}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the moment would grow in the direction of the turn" if term.coefficients[0] <= 0.0 else ""
