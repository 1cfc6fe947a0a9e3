"""Reverse thrust that differs from forward thrust."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

THRUST_TABLE_ERROR = 0.05
"""Part of the thrust: no thrust table is closer."""


class TorqueAsymmetry(Effect):
    """a = e τ for τ < 0; the coefficient is θ = 1/e − 1."""

    name = "torque_asymmetry"
    sentence = "the thrust efficiency of the negative (reverse) direction differs from that of the positive one"
    source = "J. Carlton, Marine Propellers and Propulsion, 2018, ch. 6 (four-quadrant characteristics)"
    equation = "a = e τ for τ < 0, a = τ otherwise"
    shown_by = "{effort}s of both signs and of several sizes"
    acts = "thrust"
    stage = 3

    def coefficient_bounds(self, s: Signals) -> tuple[float, float]:
        return -0.8, 5.0

    def small(self, s: Signals, term: Term) -> float:
        return 0.02

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"reverse_efficiency": 1.0 / (1.0 + term.coefficients[0])}

    def implausible(self, term: Term, s: Signals) -> str:
        efficiency = 1.0 / max(1.0 + term.coefficients[0], 1e-3)
        if not 0.2 < efficiency < 3.0:
            return f"reverse thrust would have {efficiency:.2g} times the efficiency of forward thrust"
        return ""

    def below_relevance(self, term: Term, s: Signals) -> str:
        if abs(1.0 / (1.0 + term.coefficients[0]) - 1.0) < THRUST_TABLE_ERROR:
            within = f"{THRUST_TABLE_ERROR:.0%}"
            return f"reverse thrust would be forward thrust within {within}, the error of a thrust table"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return np.where(command < 0.0, command / (1.0 + term.coefficients[0]), command)

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        return np.where(thrust < 0.0, thrust * (1.0 + term.coefficients[0]), thrust)
