"""Transport delay of the thrust, or two clocks apart."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class TorqueDelay(Effect):
    """a(t) = τ(t − D): seen from the rate side τ − a = a(t + D) − a(t). Its first order is that of a lag."""

    name = "torque_delay"
    sentence = "the thrust comes a dead time D after its command, or the clocks of the two streams are D apart"
    source = "J. E. Normey-Rico, E. F. Camacho, Control of Dead-Time Processes, 2007, ch. 2"
    acts = "thrust"
    stage = 0
    curved = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        delay = coefficients[0] if coefficients else 0.0
        delay = float(np.copysign(min(max(abs(delay), 0.25 * s.step), s.scale), delay))
        column = s.share * (s.later(s.applied, delay) - s.applied)
        if s.share < 1.0:
            column = column + (1.0 - s.share) * (s.command - s.later(s.command, -delay))
        return stack(column / delay)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"delay_s": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        if abs(term.coefficients[0]) > 0.8 * s.scale:
            return "the delay would be as long as the vehicle's own motion"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return s.later(command, -term.coefficients[0])
