"""Thrust lost to the vehicle's own motion past the thruster."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class Inflow(Effect):
    """Thrust falls by K² v |ω|. For a turning vehicle v = ℓ r and |ω| ~ √|a|: τ − a = c r √|a|.

    How fast the loss grows with the thrust depends on propeller, duct and drive: `loaded` is c r |a|.
    """

    name = "inflow"
    sentence = (
        "the thruster's inflow, from the vehicle's own turning, takes thrust in proportion to r and the rotor speed"
    )
    source = "B. Wehbe et al., IROS 2017, Section IV-A; T. I. Fossen, 1994, ch. 4 (bilinear thruster model)"
    shown_by = "large and small {effort}s at the same {rate}"
    acts = "motion"
    parameter_names = ("coefficient",)

    def __init__(self, variant: Literal["", "loaded"]) -> None:
        self.variant = variant
        self.equation = f"I ṙ + d(r) + c r {'|a|' if variant else '√|a|'} = a"

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        size = np.abs(s.applied)
        return stack(s.rate * (size if self.variant else np.sqrt(size)))

    def implausible(self, term: Term, s: Signals) -> str:
        return "motion along the thrust would add to it" if term.coefficients[0] <= 0.0 else ""
