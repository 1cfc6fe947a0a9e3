"""Thrust lost to the vehicle's own motion past the thruster."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Inflow(Effect):
    """Eq. 2: thrust falls by K² v |ω|. For a turning vehicle v = ℓ r and |ω| ~ √|a|: τ − a = c r √|a|."""

    name = "inflow"
    sentence = (
        "the thruster's inflow, from the vehicle's own turning, takes thrust in proportion to r and the rotor speed"
    )
    source = "B. Wehbe et al., IROS 2017, Eq. 2; T. I. Fossen, 1994, ch. 4 (bilinear thruster model)"
    acts = "motion"
    brief = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(s.rate * np.sqrt(np.abs(s.applied)))

    def bends(self, s: Signals, term: Term) -> Array:
        return stack(s.rate * np.abs(s.applied))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        return "motion along the thrust would add to it" if term.coefficients[0] <= 0.0 else ""
