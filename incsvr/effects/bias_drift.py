"""A constant moment that drifts."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class BiasDrift(Effect):
    """N₀ + ν (t − t₀), t₀ the start of the fitted recordings; the second column is N₀."""

    name = "bias_drift"
    sentence = "a {name} {moment} drifts slowly with time: changing trim, leakage, a warming thruster driver"
    source = (
        "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 8 (slowly varying bias)"
    )
    equation = "I ṙ + d(r) = τ + N₀ + ν (t − t₀)"
    shown_by = "a long time with {effort}s of both signs"
    acts = "outside"
    needs_clock = True
    parameter_names = ("nm_per_s", "start_nm")

    def width(self, inner: tuple[float, ...]) -> int:
        return 2

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(-(s.time - s.origin[0]), -np.ones(len(s)))

    def implausible(self, term: Term, s: Signals) -> str:
        drifted = abs(term.coefficients[0]) * (s.origin[1] - s.origin[0])
        return "the drift would exceed every command" if drifted > 2.0 * float(np.max(np.abs(s.torque))) else ""
