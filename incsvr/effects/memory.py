"""Damping that depends on the past."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array, root_mean_square

MIN_MEMORY_SCALES = 1.0
"""Shortest time constant in time scales of the motion: nothing tells water that follows sooner from an inertia, or from
the colour of the disturbance."""
MAX_MEMORY_SCALES = 10.0
"""Longest time constant in time scales of the motion."""

EDGE_FACTOR = 1.02
"""Factor on the shortest memory that is tried within which a search has ended there, and would go on."""

MIN_ENTRAINMENT = 0.01
"""Least β, of the hull's rate what the water that it drags in takes on, of which the secant is taken."""
MAX_ENTRAINMENT = 0.9
"""Largest β likewise."""


class Memory(Effect):
    """With T m' = r − m, the rate of the water m: a moment −g m, or drag in water that turns along, d(r − β m).

    Co-rotating water gives g > 0, unsteady flow either sign. Of the drag, g is β times the drag's mean slope between
    ±r̄, the root mean square rate; what it takes, d(r − β m) − d(r), is written as the secant up to β.
    """

    name = "memory"
    sentence = "the damping depends on the past of the {rate}: co-rotating water or unsteady flow (fluid memory)"
    source = "W. E. Cummins, Schiffstechnik 9, 1962 (memory of the fluid); T. I. Fossen, 2011, ch. 5"
    shown_by = "fast reversals, and steady motion of several time constants T"
    acts = "motion"
    searched = True
    multiplicity = 8.0
    lingers = True

    def __init__(self, variant: Literal["linear", "co-rotating"]) -> None:
        self.variant = variant
        self.curved = variant == "co-rotating"
        self.equation = f"I ṙ + {'d(r − β m)' if self.curved else 'd(r) − g m'} = τ, T ṁ = r − m"

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        usual = root_mean_square(s.rate)
        return [(usual, float(constant)) for constant in np.geomspace(*self.bounds(s), 7)]

    def bounds(self, s: Signals) -> tuple[float, float]:
        return MIN_MEMORY_SCALES * s.scale, MAX_MEMORY_SCALES * s.scale

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        water = s.lowpass(s.rate, inner[-1])
        if self.variant == "linear":
            return stack(water)
        slope = s.drag_slope(inner[0])
        carried = (
            min(max(-coefficients[0] / slope, MIN_ENTRAINMENT), MAX_ENTRAINMENT) if coefficients else MIN_ENTRAINMENT
        )
        return stack((s.damping - s.drag_at(s.rate - carried * water)) / (carried * slope))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"gain_nm_s": -term.coefficients[0], "time_constant_s": term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        if term.inner[-1] < EDGE_FACTOR * self.bounds(s)[0]:
            return "water that follows so fast acts as additional {inertia}"
        if self.variant == "co-rotating":
            carried = -term.coefficients[0] / s.drag_slope(term.inner[0])
            return "" if 0.0 < carried < MAX_ENTRAINMENT else "the water would turn against the vehicle, or ahead of it"
        if abs(term.coefficients[0]) * float(np.std(s.rate)) > 3.0 * float(np.std(s.torque) + np.std(s.damping)):
            return "the moment of the moving water would exceed thrust and damping"
        return ""
