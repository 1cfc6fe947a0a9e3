"""The twist of a tether."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class Tether(Effect):
    """I ṙ + d(r) + k (ψ − ψ₀) = τ, untwisted at a ψ₀ that the data place.

    A `slack` one gives nothing up to a twist of s to either side of where the recording began or of heading zero, and
    k (|ψ − ψ₀| − s) beyond.
    """

    name = "tether"
    sentence = "a tether {draws} the vehicle back with a {moment} that grows with the turned angle"
    source = "F. Dukan, M. Ludvigsen, A. J. Sørensen, OCEANS 2011 (ROV with umbilical)"
    shown_by = "turns to both sides that twist the tether, with a measured heading"
    acts = "motion"
    multiplicity = 2.0

    def __init__(self, variant: Literal["", "slack"]) -> None:
        self.variant = variant
        slack = "I ṙ + d(r) + k (ψ − ψ₀ ∓ s) = τ for |ψ − ψ₀| > s"
        self.equation = slack if variant else "I ṙ + d(r) + k (ψ − ψ₀) = τ"
        self.searched = variant == "slack"
        self.multiplicity = 6.0 if self.searched else 1.0

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        if not self.searched:
            return [(float(np.mean(s.heading)),)]
        low, high = self.bounds(s)
        neutral = (float(s.heading[0]), 0.0)
        return [(angle, float(slack)) for angle in neutral for slack in np.linspace(low, high, 4)]

    def bounds(self, s: Signals) -> tuple[float, float]:
        twist = float(np.quantile(np.abs(s.heading - s.heading[0]), 0.99))
        return 0.1 * twist, 0.7 * twist

    def width(self, inner: tuple[float, ...]) -> int:
        return 1 if self.searched else 2

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        twist = s.heading - inner[0]
        if self.searched:
            return stack(twist - np.clip(twist, -inner[1], inner[1]))
        return stack(twist, -np.ones_like(twist))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        stiffness, *moment = term.coefficients
        neutral = term.inner[0] + (moment[0] / stiffness if moment and stiffness else 0.0)
        found = {"stiffness_nm_per_rad": stiffness, "neutral_rad": neutral}
        return found | ({"slack_rad": term.inner[1]} if self.searched else {})

    def implausible(self, term: Term, s: Signals) -> str:
        return "the moment would grow in the direction of the turn" if term.coefficients[0] <= 0.0 else ""
