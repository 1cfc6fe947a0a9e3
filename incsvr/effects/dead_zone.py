"""Dead band of the thrusters."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

START_COUNTS = {"shifted": 9, "step": 16}
"""Numbers of half widths that are tried, by form; past a step's edge little of a command that stays about it is
explained."""
NOISE_DEVIATIONS = 3.0
"""Deviations of a measured torque's noise: a dead band within them predicts better because it silences the noise."""


class DeadZone(Effect):
    """Nothing comes out for |τ| < w; beyond, either all of τ (`step`) or what exceeds w (`shifted`)."""

    name = "dead_zone"
    sentence = "the thrusters have a dead band: they give nothing while the commanded {moment} is small"
    source = "D. R. Yoerger, J. G. Cooke, J.-J. E. Slotine, IEEE J. Oceanic Eng. 15(3), 1990"
    shown_by = "small commands within the band, beside larger ones"
    acts = "thrust"
    stage = 1
    searched = True
    fixed_coefficient = True
    multiplicity = 12.0
    parameter_names = ("half_width_nm",)

    def __init__(self, variant: Literal["shifted", "step"]) -> None:
        self.variant = variant
        beyond = "τ − w sgn(τ)" if variant == "shifted" else "τ"
        self.equation = f"a = 0 for |τ| < w, a = {beyond} otherwise"

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        low, high = self.bounds(s)
        return [(float(w),) for w in np.geomspace(low, high, START_COUNTS[self.variant])] if high > 0.0 else []

    def bounds(self, s: Signals) -> tuple[float, float]:
        largest = float(np.quantile(np.abs(s.torque), 0.99))
        return 0.02 * largest, 0.5 * largest

    def nudge(self, s: Signals, k: int) -> float:
        # a step's edge passes commands one by one: so many must change sides that their number is a slope
        return 0.02 * float(np.quantile(np.abs(s.torque), 0.99)) if self.variant == "step" else 0.0

    def below_relevance(self, term: Term, s: Signals) -> str:
        if term.inner[-1] < NOISE_DEVIATIONS * s.torque_noise:
            return "the dead band would lie within the noise of the measured {effort}, which it takes away"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        width = term.inner[-1]
        lost = (
            np.clip(command, -width, width)
            if self.variant == "shifted"
            else np.where(np.abs(command) < width, command, 0.0)
        )
        return command - term.coefficients[0] * lost

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        width, size = term.inner[-1], np.abs(thrust)
        beyond = size + width if self.variant == "shifted" else np.maximum(size, width)
        needed = size > (0.0 if self.variant == "shifted" else 0.5 * width)
        return np.where(needed, np.copysign(beyond, thrust), 0.0)
