"""Reverse thrust that differs from forward thrust."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals

KNOWN = 0.03
"""Of the thrust: no thrust table is closer."""


class TorqueAsymmetry(Effect):
    """a = e τ for τ < 0: seen from the rate side τ − a = (1/e − 1) min(a, 0); θ = 1/e − 1."""

    name = "torque_asymmetry"
    sentence = "the thrust efficiency of the negative (reverse) direction differs from that of the positive one"
    source = "J. Carlton, Marine Propellers and Propulsion, 2018, ch. 6 (four-quadrant characteristics)"
    acts = "thrust"
    stage = 3
    curved = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if s.from_rate:
            return stack(_reverse(s.applied))
        theta = max(coefficients[0], -0.8) if coefficients else 0.0
        return stack(s.over_jumps(s.command, _reverse) / (1.0 + theta))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"reverse_efficiency": 1.0 / (1.0 + term.coefficients[0])}

    def implausible(self, term: Term, s: Signals) -> str:
        efficiency = 1.0 / max(1.0 + term.coefficients[0], 1e-3)
        if not 0.2 < efficiency < 3.0:
            return f"reverse thrust would have {efficiency:.2g} times the efficiency of forward thrust"
        return ""

    def slight(self, term: Term, s: Signals) -> str:
        if abs(1.0 / (1.0 + term.coefficients[0]) - 1.0) < KNOWN:
            return f"reverse thrust would be forward thrust within {KNOWN:.0%}, better than a thrust table is known"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        backward = 1.0 / (1.0 + term.coefficients[0])
        return s.over_jumps(command, lambda c: np.where(c < 0.0, backward * c, c))


class CommandedAsymmetry(TorqueAsymmetry):
    """The same before a limit: what is asked of the thruster in reverse is less, and is cut at the same moment."""

    variant = "before a limit"
    sentence = (
        "the thrust efficiency of the negative (reverse) direction differs from that of the positive one, before a "
        "limit that cuts either at the same moment"
    )
    stage = 1
    beside = "torque_saturation"


def _reverse(thrust: Array) -> Array:
    return np.minimum(thrust, 0.0)
