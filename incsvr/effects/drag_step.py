"""Damping that jumps."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class DragStep(Effect):
    """d(r) is multiplied by 1 + f from the instant t_s on: a hull or payload mounted, something lost or caught."""

    name = "drag_step"
    sentence = (
        "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} jumps at one instant: another hull, a payload, "
        "something caught"
    )
    source = "B. Wehbe et al., IROS 2017, Section IV-C (hull around the rear thruster)"
    equation = "I ṙ + d(r) (1 + f) = τ from the instant t_s on"
    shown_by = "the same {rates} before and after the instant"
    acts = "damping"
    searched = True
    multiplicity = 25.0
    needs_clock = True
    parameter_names = ("fraction", "at_s")

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        low, high = self.bounds(s)
        return [(float(at),) for at in np.linspace(low, high, 25)]

    def bounds(self, s: Signals) -> tuple[float, float]:
        begin, end = s.origin
        return begin + 0.04 * (end - begin), end - 0.04 * (end - begin)

    def small(self, s: Signals, term: Term) -> float:
        return 0.02

    def nudge(self, s: Signals, k: int) -> float:
        return 0.5 * s.block if k == 1 else 0.0

    def _after(self, s: Signals, at: float) -> Array:
        # one block wide, so that the search over the instant is smooth
        after: Array = np.clip((s.time - at) / s.block + 0.5, 0.0, 1.0)
        return after

    def implausible(self, term: Term, s: Signals) -> str:
        fraction = term.coefficients[0]
        return f"the damping would change by {fraction:.0%}" if not -0.9 < fraction < 5.0 else ""

    def factor(self, s: Signals, term: Term) -> Array:
        return 1.0 + term.coefficients[0] * self._after(s, term.inner[-1])
