"""A moment that depends on the sign of the yaw rate alone."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Coulomb(Effect):
    """N_c sgn(r), made continuous as tanh(r/r_c) with r_c a hundredth of the fastest turn: dry friction of a test rig,
    a tether dragged over the ground."""

    name = "coulomb"
    sentence = "dry (Coulomb) friction: a moment of constant size against the sense of turning"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994"
    acts = "motion"

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(0.01 * float(np.quantile(np.abs(s.rate), 0.99)),)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(np.tanh(s.rate / inner[-1]))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"moment_nm": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the friction would drive the turn" if term.coefficients[0] <= 0.0 else ""
