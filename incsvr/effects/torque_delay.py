"""Transport delay of the thrust, or two clocks apart."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

MAX_DELAY_SETTLINGS = 0.8
"""Part of the settling time beyond which a delay is no delay."""


class TorqueDelay(Effect):
    """a(t) = τ(t − D) with D > 0: no thruster runs ahead of its command. Its first order is a lag's."""

    name = "torque_delay"
    sentence = "the thrust follows its command after a dead time D, or the clocks of the two streams are D apart"
    source = "J. E. Normey-Rico, E. F. Camacho, Control of Dead-Time Processes, 2007, ch. 2"
    equation = "a(t) = τ(t − D)"
    shown_by = "sudden changes of the command, and stamps of one clock"
    acts = "thrust"
    stage = 0
    from_start = True
    lingers = True
    parameter_names = ("delay_s",)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(delay),) for delay in np.geomspace(0.25 * s.step, MAX_DELAY_SETTLINGS * s.settling, 6)]

    def coefficient_bounds(self, s: Signals) -> tuple[float, float]:
        return 0.0, 1.5 * s.scale

    def nudge(self, s: Signals, k: int) -> float:
        return 0.05 * s.step

    def implausible(self, term: Term, s: Signals) -> str:
        if term.coefficients[0] > MAX_DELAY_SETTLINGS * s.settling:
            return "the delay would be as long as the vehicle's own motion"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return s.later(command, -term.coefficients[0])

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        return thrust
