"""A moment that depends on the heading."""

from __future__ import annotations

import math

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class HeadingCurrent(Effect):
    """A sin(k ψ + φ): k = 1 a current's drag on an unbalanced hull, k = 2 the Munk moment (Y_v̇ − X_u̇) u v."""

    name = "heading_current"
    sentence = "a {moment} that depends on heading: a current's drag (once a turn) or its Munk moment (twice a turn)"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 8 (ocean currents)"
    shown_by = "motion through many headings, best in full turns, with a measured heading"
    acts = "motion"

    def __init__(self, harmonic: int) -> None:
        self.harmonic = harmonic
        self.variant = str(harmonic)
        self.equation = f"I ṙ + d(r) = τ + A sin({'' if harmonic == 1 else harmonic}ψ + φ)"

    def width(self, inner: tuple[float, ...]) -> int:
        return 2

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        angle = self.harmonic * s.heading
        return stack(-np.sin(angle), -np.cos(angle))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        sine, cosine = term.coefficients
        return {
            "amplitude_nm": math.hypot(sine, cosine),
            "phase_rad": math.atan2(cosine, sine),
            "harmonic": float(self.harmonic),
        }

    def implausible(self, term: Term, s: Signals) -> str:
        amplitude = math.hypot(*term.coefficients)
        if amplitude > float(np.max(np.abs(s.torque))) + float(np.max(np.abs(s.damping))):
            return "the moment of the current would exceed thrust and damping"
        angle_range = max((float(np.ptp(s.heading[run])) for run in s.runs()), default=0.0)
        if angle_range * self.harmonic < 0.7:
            return f"the vehicle turned through {math.degrees(angle_range):.0f}° only"
        return ""
