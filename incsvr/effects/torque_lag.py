"""First-order rotor dynamics."""

from __future__ import annotations

import numpy as np

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

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(constant),) for constant in np.geomspace(0.5 * s.step, s.scale, 2 if s.from_rate else 6)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if s.from_rate:
            return stack(s.slope(s.applied))
        if not coefficients:  # the secant from no lag to the start of the search
            return stack((s.command - s.lowpass(s.command, inner[0])) / inner[0])
        return stack(self._tangent(s, self._within(s, coefficients)))

    def offset(self, s: Signals, coefficients: tuple[float, ...]) -> Array | None:
        if s.from_rate or not coefficients:
            return None
        constant = self._within(s, coefficients)
        offset: Array = s.command - s.lowpass(s.command, constant) - constant * self._tangent(s, constant)
        return offset

    def _tangent(self, s: Signals, constant: float) -> Array:
        tangent: Array = s.lowpass(s.command, 0.98 * constant) - s.lowpass(s.command, 1.02 * constant)
        return tangent / (0.04 * constant)

    def _within(self, s: Signals, coefficients: tuple[float, ...]) -> float:
        return min(max(coefficients[0], 0.25 * s.step), 2.0 * s.scale)

    def noise_gain(self, term: Term, s: Signals) -> float:
        """Thrust space: the torque's noise passes the lag. Command space: the water's noise passes its inverse."""
        frequency = np.pi / s.block * (np.arange(64) + 0.5) / 64.0
        inverse = 1.0 + (frequency * max(term.coefficients[0], 0.0)) ** 2
        if s.from_rate:
            return float(np.mean(np.log(s.share + (1.0 - s.share) * inverse)))
        return float(np.mean(np.log(s.share / inverse + 1.0 - s.share)))

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
