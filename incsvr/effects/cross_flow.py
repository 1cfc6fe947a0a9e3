"""Damping that grows with the size of another velocity."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class CrossFlow(Effect):
    """I ṙ + d(r) + c |a| r = τ: a hull that moves with a is damped in r by what the flow along a carries away.

    In yaw of a boat under way c |u| r is N_{|u|r}, often the largest damping; that of cross-flow drag is c |v| r.
    """

    sentence = "the damping grows with the size of another velocity: cross-flow drag, or damping by speed"
    source = "O. M. Faltinsen, Sea Loads on Ships and Offshore Structures, 1990; T. I. Fossen, 2011, ch. 6 (N_|v|r)"
    equation = "I ṙ + d(r) + c |x| r = τ"
    shown_by = "several {rates} while x is slow and while it is fast"
    acts = "motion"
    parameter_names = ("coefficient",)

    def __init__(self, channel: str) -> None:
        self.name = f"cross_flow:{channel}"
        self.channels = (channel,)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(np.abs(s.channels[self.channels[0]]) * s.rate)

    def implausible(self, term: Term, s: Signals) -> str:
        return "the other velocity would drive the turn" if term.coefficients[0] <= 0.0 else ""
