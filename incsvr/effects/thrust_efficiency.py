"""The whole thrust scaled: a rival of the inertia that no yaw recording can tell from it."""

from __future__ import annotations

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class ThrustEfficiency(Effect):
    """I ṙ + d(r) = g τ. Never named on its own: it exists so that its tie with `inertia` is computed, not asserted."""

    name = "thrust_efficiency"
    sentence = "all thrusters give g times the moment that the table says"
    source = "T. I. Fossen, Guidance and Control of Ocean Vehicles, 1994, ch. 4 (thruster models)"
    acts = "thrust"
    stage = 4
    curved = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        missing = coefficients[0] if coefficients else 0.0  # 1 − g
        return stack(s.applied / max(1.0 - missing, 0.2) if s.from_rate else s.command)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"efficiency": 1.0 - term.coefficients[0]}

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return (1.0 - term.coefficients[0]) * command
