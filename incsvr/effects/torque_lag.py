"""First-order rotor dynamics."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class TorqueLag(Effect):
    """T n' + n = n₀: of the moment, n = a and n₀ = τ, or of the rotor speed, whose moment is n |n|.

    A filter of the gyro, T r_m′ + r_m = r, shows the answer as late: only how the vehicle answers the water tells them
    apart.
    """

    name = "torque_lag"
    sentence = "the thrust follows the command with first-order rotor dynamics of time constant T"
    source = "L. L. Whitcomb, D. R. Yoerger, IEEE J. Oceanic Eng. 24(4), 1999 (thruster dynamics)"
    shown_by = "sudden changes of the command"
    acts = "thrust"
    stage = 5
    from_start = True
    lingers = True
    ties = ("gyro_lag",)
    parameter_names = ("time_constant_s",)

    def __init__(self, variant: Literal["moment", "rotor speed"]) -> None:
        self.variant = variant
        rotor = "T ṅ + n = sgn(τ) √|τ|, a = n |n|"
        self.equation = "T ȧ + a = τ" if variant == "moment" else rotor

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(t),) for t in np.geomspace(0.5 * s.step, s.scale, 6)]

    def coefficient_bounds(self, s: Signals) -> tuple[float, float]:
        return 0.1 * s.step, 2.0 * s.scale

    def nudge(self, s: Signals, k: int) -> float:
        return 0.05 * s.step

    def implausible(self, term: Term, s: Signals) -> str:
        return "the rotor would be slower than the vehicle" if term.coefficients[0] > s.settling else ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        constant = max(term.coefficients[0], 0.1 * s.step)
        if self.variant == "moment":
            return s.lowpass(command, constant)
        speed = s.lowpass(np.sign(command) * np.sqrt(np.abs(command)), constant)
        return np.asarray(speed * np.abs(speed))

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        constant = max(term.coefficients[0], 0.1 * s.step)
        turns = thrust if self.variant == "moment" else np.sign(thrust) * np.sqrt(np.abs(thrust))
        if turns.size > 1:
            turns = turns + constant * np.gradient(turns, s.step)
        return turns if self.variant == "moment" else np.asarray(turns * np.abs(turns))
