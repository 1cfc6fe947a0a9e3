"""Transport delay of the thrust, or two clocks apart."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class TorqueDelay(Effect):
    """a(t) = τ(t − D), of the command as recorded: its noise moves with it, so nothing is lost by it.

    From the rate side, τ − a = a(t + D) − a(t), damping and delay would be found in turns, which does not settle where
    D is more than a sixth of a period, as in a loop that the delay keeps from settling. Its first order is a lag's.
    """

    name = "torque_delay"
    sentence = "the thrust comes a dead time D after its command, or the clocks of the two streams are D apart"
    source = "J. E. Normey-Rico, E. F. Camacho, Control of Dead-Time Processes, 2007, ch. 2"
    acts = "thrust"
    stage = 0
    curved = True
    secant = True
    shifts = True
    lingers = True

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        later = [(float(delay),) for delay in np.geomspace(0.25 * s.step, 0.8 * s.settling, 6)]
        return [*later, (-0.05 * s.scale,), (-0.2 * s.scale,)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if not coefficients:  # the secant from no delay to the start of the search
            return stack(self._lost(s, inner[0]) / inner[0])
        return stack(self._tangent(s, self._within(s, coefficients)))

    def offset(self, s: Signals, coefficients: tuple[float, ...], columns: Array) -> Array | None:
        if not coefficients:
            return None
        delay = self._within(s, coefficients)
        offset: Array = self._lost(s, delay) - delay * columns[:, 0]
        return offset

    def _lost(self, s: Signals, delay: float) -> Array:
        return s.command - s.later(s.command, -delay)

    def _tangent(self, s: Signals, delay: float) -> Array:
        half = 0.5 * s.step
        return (self._lost(s, delay + half) - self._lost(s, delay - half)) / s.step

    def _within(self, s: Signals, coefficients: tuple[float, ...]) -> float:
        most = s.settling
        return min(max(coefficients[0], -most), most)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"delay_s": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        if abs(term.coefficients[0]) > 0.8 * s.settling:
            return "the delay would be as long as the vehicle's own motion"
        if term.coefficients[0] < -0.1 * s.scale:
            return "the thrust would run ahead of its command by more than clocks are apart"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return s.later(command, -term.coefficients[0])
