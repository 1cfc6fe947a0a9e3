"""The effect of another moment of inertia than the declared one."""

from __future__ import annotations

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals

DECLARED_INERTIA_ERROR = 0.05
"""Part of the declared inertia to which it is known: no pendulum test or added mass by strip theory is closer."""


class Inertia(Effect):
    """(I₀ + ΔI) ṙ + d(r) = τ: dry inertia and added mass −N_ṙ.

    The whole thrust scaled by g explains the same data with I/g and d/g: the two tie exactly.
    """

    name = "inertia"
    sentence = "the {inertia_with_added_mass}, {added_mass}, differs from the declared one"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 6 (added mass)"
    equation = "(I₀ + ΔI) ṙ + d(r) = τ"
    shown_by = "{effort}s that change so fast that the {inertia} counts as much as the damping"
    acts = "inertia"
    ties = ("thrust_efficiency",)

    def coefficient_bounds(self, s: Signals) -> tuple[float, float]:
        return -0.95 * s.inertia, 50.0 * s.inertia

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"inertia_kg_m2": inertia + term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        return "the {inertia} would be negative" if term.coefficients[0] <= -s.inertia else ""

    def below_relevance(self, term: Term, s: Signals) -> str:
        if abs(term.coefficients[0]) < DECLARED_INERTIA_ERROR * s.inertia:
            within = f"{DECLARED_INERTIA_ERROR:.0%}"
            return f"the {{inertia}} would equal the declared one within {within}, the accuracy of a declaration"
        return ""
