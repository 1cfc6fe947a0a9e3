"""A moment that depends on the sign of the yaw rate alone."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals

CREEP = {"": (0.01, 0.03), "sharp": (0.001, 0.003)}
"""r_c, in parts of the fastest turn."""

AT_REST = 5.0
"""r_c below which the vehicle may be held."""


class Coulomb(Effect):
    """N_c sgn(r), made continuous as tanh(r/r_c): dry friction of a test rig, a tether dragged over the ground.

    Where it holds the vehicle at rest, too wide an r_c takes that for a far larger friction, and a narrow one, where
    the turn but reverses, sees the gyro's noise: both forms are tried.

    A turn reverses within a sample or two, so that the column is the mean of the tanh over the rates that the vehicle
    passes between the samples; the free run takes the friction itself, which can hold the vehicle.
    """

    name = "coulomb"
    sentence = "dry (Coulomb) friction: a moment of constant size against the sense of turning"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994"
    acts = "motion"
    looks = 2.0
    dry_friction = True

    def __init__(self, variant: Literal["", "sharp"]) -> None:
        self.variant = variant

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        fastest = float(np.quantile(np.abs(s.rate), 0.99))
        return [(part * fastest,) for part in CREEP[self.variant]]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        before, after = s.midpoints(s.rate)
        return stack(0.5 * (_swept(before, s.rate, inner[-1]) + _swept(s.rate, after, inner[-1])))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"moment_nm": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the friction would drive the turn" if term.coefficients[0] <= 0.0 else ""


def _swept(a: Array, b: Array, width: float) -> Array:
    """Mean of tanh(x/width) for x from a to b."""
    span = b - a
    still = np.abs(span) < 1e-3 * width
    # ln 2 cosh x, without overflow
    high, low = (x + np.log1p(np.exp(-2.0 * x)) for x in (np.abs(b) / width, np.abs(a) / width))
    swept: Array = np.where(still, np.tanh(0.5 * (a + b) / width), width * (high - low) / np.where(still, 1.0, span))
    return swept
