"""A moment that depends on the sign of the yaw rate alone."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

CREEP_RATE_SHARES = {"": (0.01, 0.03), "sharp": (0.001, 0.003)}
"""Creep rates r_c of each form, in parts of the fastest turn."""


class Coulomb(Effect):
    """N_c sgn(r), made continuous as tanh(r/r_c): dry friction of a test rig, a tether dragged over the ground.

    Where it holds the vehicle at rest, too wide an r_c takes that for a far larger friction, and a narrow one, where
    the turn but reverses, sees the gyro's noise: both forms are tried.
    """

    name = "coulomb"
    sentence = "dry (Coulomb) friction: a {moment} of constant size against the {sense}"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994"
    equation = "I ṙ + d(r) + N_c tanh(r/r_c) = τ, with a small creep rate r_c"
    shown_by: ClassVar[str] = "slow motion in both directions, beside fast motion"
    acts = "motion"
    multiplicity = 2.0
    dry_friction = True
    parameter_names: ClassVar[tuple[str, ...]] = ("moment_nm",)

    def __init__(self, variant: Literal["", "sharp"]) -> None:
        self.variant = variant

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        fastest = float(np.quantile(np.abs(s.rate), 0.99))
        return [(part * fastest,) for part in CREEP_RATE_SHARES[self.variant]]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(np.tanh(s.rate / inner[-1]))

    def implausible(self, term: Term, s: Signals) -> str:
        return "the friction would drive the turn" if term.coefficients[0] <= 0.0 else ""
