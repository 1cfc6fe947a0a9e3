"""A thrust curve of another power than the table's."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

START_EXPONENTS = (0.5, 0.65, 0.8, 1.25, 1.5, 1.75, 2.0, 2.5)
"""Exponents from which the search begins, to either side of the table's."""

THRUST_EXPONENT_ERROR = 0.06
"""Difference of an exponent from one that says nothing: no thrust table is closer."""


class ThrustCurve(Effect):
    """a = L sgn(τ) |τ/L|^p: a thrust that goes with another power of the command than its table has it.

    A linear table of a propeller, whose thrust goes with the square of its speed, has p = 2. L is the highest command:
    another scale is another inertia.
    """

    name = "thrust_curve"
    sentence = "the thrust follows another power of the command than its table's, as the square of a rotor's speed"
    source = "T. I. Fossen, Guidance and Control of Ocean Vehicles, 1994, ch. 4 (T = K n|n|)"
    equation = "a = L sgn(τ) |τ/L|^p, with the highest command L"
    shown_by = "commands of many sizes"
    acts = "thrust"
    stage = 1
    searched = True
    fixed_coefficient = True
    multiplicity = 8.0
    parameter_names = ("exponent",)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        top = float(np.quantile(np.abs(s.torque), 0.999))
        return [(top, exponent) for exponent in START_EXPONENTS] if top > 0.0 else []

    def bounds(self, s: Signals) -> tuple[float, float]:
        return 0.4, 3.0

    def below_relevance(self, term: Term, s: Signals) -> str:
        if abs(term.inner[-1] - 1.0) < THRUST_EXPONENT_ERROR:
            return f"the exponent would be that of the table within {THRUST_EXPONENT_ERROR:g}, the error of a table"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        top, exponent = term.inner
        bent = top * np.sign(command) * np.abs(command / top) ** exponent
        return np.asarray(command + term.coefficients[0] * (bent - command))

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        top, exponent = term.inner
        return np.asarray(top * np.sign(thrust) * np.abs(thrust / top) ** (1.0 / exponent))
