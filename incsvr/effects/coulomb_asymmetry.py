"""Dry friction that differs with the direction of the turn."""

from __future__ import annotations

import numpy as np

from incsvr.effects.coulomb import Coulomb
from incsvr.effects.effect import Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

MIN_DIFFERENCE_SHARE = 0.1
"""Part of their mean by which the two moments must differ: else it is plain friction."""


class CoulombAsymmetry(Coulomb):
    """N_+ for r > 0 and −N_− for r < 0: a gear, a spring's preload, a tether that is dragged one way.

    Beyond creep it is plain friction beside a constant moment; at rest it holds the vehicle to either side otherwise.
    """

    name = "coulomb_asymmetry"
    sentence = "dry (Coulomb) friction that differs with the direction of the turn"
    equation = "I ṙ + d(r) + N_c tanh(r/r_c) = τ, with one N_c for r > 0 and another for r < 0"
    shown_by = "slow motion in both directions, with stops"
    parameter_names = ("moment_forward_nm", "moment_backward_nm")

    def width(self, inner: tuple[float, ...]) -> int:
        return 2

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        both = super().columns(s, inner, coefficients)[:, 0]
        return stack(np.maximum(both, 0.0), np.minimum(both, 0.0))

    def implausible(self, term: Term, s: Signals) -> str:
        return "the friction would drive the turn" if min(term.coefficients) <= 0.0 else ""

    def below_relevance(self, term: Term, s: Signals) -> str:
        forward, backward = term.coefficients
        if abs(forward - backward) < MIN_DIFFERENCE_SHARE * 0.5 * (forward + backward):
            return f"the friction would be the same to either side within {MIN_DIFFERENCE_SHARE:.0%}"
        return ""
