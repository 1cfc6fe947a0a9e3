"""First-order rotor dynamics."""

from __future__ import annotations

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class TorqueLag(Effect):
    """T a' + a = τ for the applied moment a: seen from the rate side τ − a = T a', exactly."""

    name = "torque_lag"
    sentence = "the thrust follows the command with first-order rotor dynamics of time constant T"
    source = "L. L. Whitcomb, D. R. Yoerger, IEEE J. Oceanic Eng. 24(4), 1999 (thruster dynamics)"
    acts = "thrust"
    stage = 5
    curved = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        constant = min(max(coefficients[0] if coefficients else 0.0, s.step), 2.0 * s.scale)
        column = s.share * s.slope(s.applied)
        if s.share < 1.0:
            column = column + (1.0 - s.share) * (s.command - s.lowpass(s.command, constant)) / constant
        return stack(column)

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"time_constant_s": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        if term.coefficients[0] <= 0.0:
            return "the thrust would run ahead of its command"
        if term.coefficients[0] > s.scale:
            return "the rotor would be slower than the vehicle"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return s.lowpass(command, max(term.coefficients[0], 0.1 * s.step))
