"""Damping that depends on the past."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals

SHORTEST = 1.5
"""Blocks: what is forgotten within one is, in its means, an inertia."""

REACH = 4.0
"""Blocks: what is forgotten within the reach of an AR(3) is told from the noise's colour by the free run alone."""

LASTING = 0.75
"""T_c: but what lasts as long is no inertia, however long the blocks are."""

EDGE = 1.02
"""Of the shortest memory that is tried: a search that ends there would go on."""


class Memory(Effect):
    """A moment g m, or with drag that grows as r|r| g m |r|/r̄, or both, with T m' = r − m and r̄ the root mean square
    rate.

    Co-rotating water gives g < 0 against the drag (d(r − β m) ≈ d(r) − β d'(r) m), unsteady flow g > 0.
    """

    name = "memory"
    sentence = "the damping depends on the past of the yaw rate: co-rotating water or unsteady flow (fluid memory)"
    source = "W. E. Cummins, Schiffstechnik 9, 1962 (memory of the fluid); T. I. Fossen, 2011, ch. 5"
    acts = "motion"
    searched = True
    looks = 8.0
    lingers = True

    def __init__(self, variant: Literal["linear", "quadratic", "both"]) -> None:
        self.variant = variant
        self.core = 2 if variant == "both" else 1

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        low, high = self.bounds(s)
        usual = float(np.sqrt(np.mean(s.rate**2)))
        return [(usual, float(constant)) for constant in np.geomspace(low, high, 7)]

    def bounds(self, s: Signals) -> tuple[float, float]:
        return max(0.1 * s.scale, SHORTEST * s.block), 10.0 * s.scale

    def must_prove(self, term: Term, s: Signals) -> bool:
        return term.inner[-1] < max(0.3 * s.scale, min(REACH * s.block, LASTING * s.scale))

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        water = s.lowpass(s.rate, inner[-1])
        faster = water * np.abs(s.rate) / inner[0]
        return stack(*{"linear": (water,), "quadratic": (faster,), "both": (water, faster)}[self.variant])

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"gain_nm_s": -sum(term.coefficients), "time_constant_s": term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        parts = np.abs(term.coefficients)
        if min(term.coefficients) < 0.0 < max(term.coefficients) and 4.0 * min(parts) > max(parts):
            return "the moving water would drag at small rates and push at large ones, or the other way round"
        if term.inner[-1] < EDGE * self.bounds(s)[0]:
            return "water that followed so fast would be but another inertia"
        gain = sum(term.coefficients) * float(np.std(s.rate))
        if abs(gain) > 3.0 * float(np.std(s.torque)) + 3.0 * float(np.std(s.damping)):
            return "the moment of the moving water would exceed thrust and damping"
        return ""
