"""First-order rotor dynamics."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class TorqueLag(Effect):
    """T n' + n = n₀: of the moment, n = a and n₀ = τ, or of the rotor speed, whose moment is n |n|.

    From the rate side the lag multiplies the noise that turned the vehicle, from the command side it is built on a
    noisy torque: `Signals.from_rate` says which is the lesser evil. A root is steepest where the thrust turns, and
    where it lingers there the rate side is all noise: then the rotor speed is seen from the command side, too. The
    columns are tangents at the last pass's T.
    """

    name = "torque_lag"
    sentence = "the thrust follows the command with first-order rotor dynamics of time constant T"
    source = "L. L. Whitcomb, D. R. Yoerger, IEEE J. Oceanic Eng. 24(4), 1999 (thruster dynamics)"
    acts = "thrust"
    stage = 5
    curved = True
    secant = True
    lingers = True

    def __init__(self, variant: Literal["moment", "rotor speed", "rotor speed, commanded"]) -> None:
        self.variant = variant

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        if self.variant == "rotor speed, commanded" and not s.from_rate:
            return []  # there the rotor speed is seen so already
        return [(float(t),) for t in np.geomspace(0.5 * s.step, s.scale, 2 if self._from_rate(s) else 6)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if not coefficients:  # the secant from no lag to the start of the search
            return stack(self._lost(s, inner[0]) / inner[0])
        return stack(self._tangent(s, self._within(s, coefficients)))

    def offset(self, s: Signals, coefficients: tuple[float, ...], columns: Array) -> Array | None:
        if not coefficients or (self._from_rate(s) and self.variant == "moment"):  # the latter is linear in T
            return None
        constant = self._within(s, coefficients)
        offset: Array = self._lost(s, constant) - constant * columns[:, 0]
        return offset

    def _lost(self, s: Signals, constant: float) -> Array:
        """(n,) what a lag of T takes from the thrust [N m]."""
        if self._from_rate(s):
            state = self._state(s.applied)
            return self._moment(state + constant * s.slope(state)) - s.applied
        return s.command - self._moment(s.lowpass(self._state(s.command), constant))

    def _from_rate(self, s: Signals) -> bool:
        return s.from_rate and self.variant != "rotor speed, commanded"

    def _state(self, moment: Array) -> Array:
        return moment if self.variant == "moment" else np.sign(moment) * np.sqrt(np.abs(moment))

    def _moment(self, state: Array) -> Array:
        return state if self.variant == "moment" else state * np.abs(state)

    def _tangent(self, s: Signals, constant: float) -> Array:
        return (self._lost(s, 1.02 * constant) - self._lost(s, 0.98 * constant)) / (0.04 * constant)

    def _within(self, s: Signals, coefficients: tuple[float, ...]) -> float:
        return min(max(coefficients[0], 0.25 * s.step), 2.0 * s.scale)

    def passed(self, term: Term, s: Signals) -> Array | None:
        """From the command side the torque's noise passes the lag; from the rate side nothing is lowered."""
        if s.known or self._from_rate(s):
            return None
        frequency = np.pi / s.block * (np.arange(64, dtype=np.float64) + 0.5) / 64.0
        passed: Array = 1.0 / (1.0 + np.square(frequency * max(term.coefficients[0], 0.0)))
        return passed

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"time_constant_s": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        if term.coefficients[0] <= 0.0:
            return "the thrust would run ahead of its command"
        if term.coefficients[0] > s.settling:
            return "the rotor would be slower than the vehicle"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return self._moment(s.lowpass(self._state(command), max(term.coefficients[0], 0.1 * s.step)))
