"""The whole thrust scaled: an alternative of the inertia that no yaw recording can tell from it."""

from __future__ import annotations

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class ThrustEfficiency(Effect):
    """a = g τ, so τ − a = (1/g − 1) a with a = I ṙ + d(r): the very columns of an inertia and a damping.

    Never named on its own and never simulated: it stands among the alternatives so that its tie is computed, not
    asserted.
    """

    name = "thrust_efficiency"
    sentence = "all thrusters give g times the moment that the table says"
    source = "T. I. Fossen, Guidance and Control of Ocean Vehicles, 1994, ch. 4 (thruster models)"
    acts = "motion"

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(s.applied)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"efficiency": 1.0 / (1.0 + term.coefficients[0])}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the thrusters would work backwards" if term.coefficients[0] <= -1.0 else ""
