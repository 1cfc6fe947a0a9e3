"""A constant moment."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class BiasTorque(Effect):
    """I ṙ + d(r) = τ + N₀. It is no damping, because d(0) = 0 (Section III-A: no drag acts on a vehicle at rest)."""

    name = "bias_torque"
    sentence = "a constant {name} {moment} N₀ acts beside the thrusters: trim, a bent fin or a thruster offset"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 12 (bias moments)"
    equation = "I ṙ + d(r) = τ + N₀"
    shown_by = "{effort}s of both signs and of several sizes"
    acts = "outside"
    parameter_names = ("moment_nm",)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(-np.ones(len(s)))

    def implausible(self, term: Term, s: Signals) -> str:
        largest = float(np.max(np.abs(s.torque)))
        if largest > 0.0 and abs(term.coefficients[0]) > largest:
            return "the constant {moment} would exceed every commanded one"
        return ""
