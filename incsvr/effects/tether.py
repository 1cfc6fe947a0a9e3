"""The twist of a tether."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Tether(Effect):
    """I ṙ + d(r) + k (ψ − ψ₀) = τ, untwisted at ψ₀: where the recording began, or at heading zero.

    Any other ψ₀ is, in the equation, the same tether beside a constant moment.
    """

    name = "tether"
    sentence = "a tether turns the vehicle back with a moment that grows with the turned angle"
    source = "F. Dukan, M. Ludvigsen, A. J. Sørensen, OCEANS 2011 (ROV with umbilical)"
    acts = "motion"
    looks = 2.0

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(s.heading[0]),), (0.0,)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(s.heading - inner[-1])

    def bends(self, s: Signals, term: Term) -> Array:
        twist = s.heading - term.inner[-1]
        return stack(twist * np.abs(twist), twist**3)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"stiffness_nm_per_rad": term.coefficients[0], "neutral_rad": term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the moment would grow in the direction of the turn" if term.coefficients[0] <= 0.0 else ""
