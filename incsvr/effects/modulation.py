"""Thrust or damping scaled by another channel."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class _Modulation(Effect):
    def __init__(self, channel: str) -> None:
        self.name = f"modulation:{channel}"
        self.channels = (channel,)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(np.mean(s.channels[self.channels[0]])),)]

    def away(self, s: Signals, inner: tuple[float, ...]) -> Array:
        away: Array = s.channels[self.channels[0]] - inner[0]
        return away


class ThrustModulation(_Modulation):
    """a = g τ with g = 1 + c (x − x̄): supply voltage, depth, a blocked nozzle."""

    variant = "thrust"
    sentence = "the thrust is scaled by another channel, as by the supply voltage"
    source = "A. J. Healey et al., IEEE J. Oceanic Eng. 20(4), 1995 (motor voltage and thrust)"
    acts = "thrust"
    stage = 4
    curved = True

    def gain(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if not coefficients:
            return np.ones(len(s))
        return np.clip(1.0 + coefficients[0] * self.away(s, inner), 0.2, 3.0)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        seen = s.applied / self.gain(s, inner, coefficients) if s.from_rate else s.command
        return stack(-self.away(s, inner) * seen)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0], "reference": term.inner[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        gain = 1.0 + term.coefficients[0] * self.away(s, term.inner)
        return "the thrust would change its sign" if float(np.quantile(gain, 0.01)) <= 0.1 else ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        thrust: Array = command * self.gain(s, term.inner, term.coefficients)
        return thrust


class LevelledThrustModulation(ThrustModulation):
    """The same where the thrust table holds at another level of the channel than its mean (the second column)."""

    variant = "thrust, own level"

    def gain(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if not coefficients:
            return np.ones(len(s))
        return np.clip(1.0 + coefficients[1] + coefficients[0] * self.away(s, inner), 0.2, 3.0)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        seen = s.applied / self.gain(s, inner, coefficients) if s.from_rate else s.command
        return stack(-self.away(s, inner) * seen, -seen)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        slope, level = term.coefficients
        return {"coefficient": slope, "reference": term.inner[0] - level / slope if slope else term.inner[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        values = s.channels[self.channels[0]]
        low, high = (float(q) for q in np.quantile(values, [0.01, 0.99]))
        reference = self.parameters(term, 1.0)["reference"]
        if abs(term.coefficients[1]) > 0.5:
            return "at the channel's mean the thrust would already be far from its table: that is another inertia"
        if not low - 0.5 * (high - low) <= reference <= high + 0.5 * (high - low):
            return f"the thrust table would hold at {reference:.3g}, far from what the channel ever was"
        return super().implausible(term, s)


class DampingModulation(_Modulation):
    """d(r) is multiplied by 1 + c (x − x̄): draught, a manipulator's reach, temperature."""

    variant = "damping"
    sentence = "the damping is scaled by another channel"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 6 (damping)"
    acts = "damping"

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(self.away(s, inner) * s.damping)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0], "reference": term.inner[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        factor = 1.0 + term.coefficients[0] * self.away(s, term.inner)
        return "the damping would change its sign" if float(np.quantile(factor, 0.01)) <= 0.0 else ""

    def factor(self, s: Signals, term: Term) -> Array:
        return np.maximum(1.0 + term.coefficients[0] * self.away(s, term.inner), 0.05)
