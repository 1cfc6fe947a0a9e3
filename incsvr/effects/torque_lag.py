"""First-order rotor dynamics."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import FROM_RATE, Effect, Term, seen_from, stack
from incsvr.effects.signals import Array, Signals


class TorqueLag(Effect):
    """T a' + a = τ for the applied moment a: seen from the rate side τ − a = T a', exactly.

    From the rate side the lag multiplies the noise that turned the vehicle, from the command side it is built on a
    noisy torque; which is the lesser evil depends on the recordings, so both stand in the catalogue.
    """

    name = "torque_lag"
    sentence = "the thrust follows the command with first-order rotor dynamics of time constant T"
    source = "L. L. Whitcomb, D. R. Yoerger, IEEE J. Oceanic Eng. 24(4), 1999 (thruster dynamics)"
    acts = "thrust"
    stage = 5
    curved = True

    def __init__(self, variant: str) -> None:
        self.variant = variant
        self._from_rate = variant == FROM_RATE

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        if not seen_from(self.variant, s):
            return []
        return [(float(constant),) for constant in np.geomspace(0.5 * s.step, s.scale, 2 if self._from_rate else 6)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if self._from_rate:
            return stack(s.slope(s.applied))
        if not coefficients:  # the secant from no lag to the start of the search
            return stack((s.command - s.lowpass(s.command, inner[0])) / inner[0])
        return stack(self._tangent(s, self._within(s, coefficients)))

    def offset(self, s: Signals, coefficients: tuple[float, ...]) -> Array | None:
        if self._from_rate or not coefficients:
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
        """From the command side the torque's noise passes the lag, in part; from the rate side nothing is lowered."""
        if self._from_rate:
            return 0.0
        frequency = np.pi / s.block * (np.arange(64) + 0.5) / 64.0
        passed = 1.0 / (1.0 + (frequency * max(term.coefficients[0], 0.0)) ** 2)
        return float(np.mean(np.log(s.share * passed + 1.0 - s.share)))

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
