"""Thrust or damping scaled by another channel."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

MIN_THRUST_FACTOR = 0.2
"""Least factor on the thrust, whatever the channel does."""
MAX_THRUST_FACTOR = 3.0
"""Largest factor on the thrust, whatever the channel does."""
MIN_DAMPING_FACTOR = 0.05
"""Least factor on the damping, whatever the channel does."""


class _Modulation(Effect):
    def __init__(self, channel: str) -> None:
        self.name = f"modulation:{channel}"
        self.channels = (channel,)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(np.mean(self.value(s))),)]

    def value(self, s: Signals) -> Array:
        """(n,) what the factor follows."""
        return s.channels[self.channels[0]]

    def away(self, s: Signals, inner: tuple[float, ...]) -> Array:
        """(n,) by how much that differs from its reference."""
        return np.asarray(self.value(s) - inner[0])

    def small(self, s: Signals, term: Term) -> float:
        return 0.02 / max(float(np.std(self.away(s, term.inner))), 1e-300)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0], "reference": term.inner[0]}


class ThrustModulation(_Modulation):
    """a = g τ with g = 1 + c (x − x̄): supply voltage, depth, a blocked nozzle."""

    variant = "thrust"
    sentence = "the thrust is scaled by another channel, as by the supply voltage"
    source = "A. J. Healey et al., IEEE J. Oceanic Eng. 20(4), 1995 (motor voltage and thrust)"
    equation = "a = (1 + c (x − x̄)) τ, with the mean x̄"
    shown_by = "several values of the channel at the same {effort}"
    acts = "thrust"
    stage = 4

    def implausible(self, term: Term, s: Signals) -> str:
        gain = 1.0 + term.coefficients[0] * self.away(s, term.inner)
        return "the thrust would change its sign" if float(np.quantile(gain, 0.01)) <= 0.1 else ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return np.asarray(command * self._gain(s, term))

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        return np.asarray(thrust / self._gain(s, term))

    def _gain(self, s: Signals, term: Term) -> Array:
        """(n,) g."""
        return np.clip(1.0 + term.coefficients[0] * self.away(s, term.inner), MIN_THRUST_FACTOR, MAX_THRUST_FACTOR)


class DampingModulation(_Modulation):
    """d(r) is multiplied by 1 + c (x − x̄): draught, a manipulator's reach, temperature."""

    variant = "damping"
    sentence = "the damping is scaled by another channel"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 6 (damping)"
    equation = "I ṙ + d(r) (1 + c (x − x̄)) = τ, with the mean x̄"
    shown_by = "several values of the channel at the same {rate}"
    acts = "damping"

    def implausible(self, term: Term, s: Signals) -> str:
        factor = 1.0 + term.coefficients[0] * self.away(s, term.inner)
        return "the damping would change its sign" if float(np.quantile(factor, 0.01)) <= 0.0 else ""

    def factor(self, s: Signals, term: Term) -> Array:
        return np.maximum(1.0 + term.coefficients[0] * self.away(s, term.inner), MIN_DAMPING_FACTOR)
