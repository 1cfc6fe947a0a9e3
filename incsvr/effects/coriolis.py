"""The product of two velocities: Coriolis force, Munk moment, lift."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class Coriolis(Effect):
    """I ṙ + d(r) + c a b = τ with the velocities a and b, of which one may be the axis's own.

    In sway c of u r is m − X_u̇, in surge that of v r is −(m − Y_v̇) and that of r² −m x_g; in yaw that of u v is
    X_u̇ − Y_v̇, the Munk moment (Fossen 2011, Eq. 6.43 and 6.50, M diagonal). With the own velocity it is what the centre
    of gravity off the origin (m x_g u r) and lift add; the own square is damping.
    """

    equation = "I ṙ + d(r) + c x y = τ with the velocities x and y"
    shown_by = "both velocities together, each with both signs if it has them"
    source = (
        "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 6 (rigid-body and "
        "hydrodynamic Coriolis–centripetal matrices)"
    )
    sentence = (
        "the product of two velocities {drives} the vehicle: Coriolis and centripetal terms, with the added mass the "
        "Munk moment, and lift"
    )

    def __init__(self, first: str, second: str, own: str = "") -> None:
        """`own` is that of the two which is the axis's own velocity, if one is."""
        self.name = f"coriolis:{first}*{second}"
        self.variant = own
        self.channels = tuple(dict.fromkeys(name for name in (first, second) if name != own))
        self.acts = "motion" if own else "outside"

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        first = s.channels[self.channels[0]]
        return stack(first * (s.rate if self.variant else s.channels[self.channels[-1]]))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0], "ratio": term.coefficients[0] / inertia}

    def implausible(self, term: Term, s: Signals) -> str:
        product = self.columns(s, (), ())[:, 0]
        taken = abs(term.coefficients[0]) * float(np.std(product))
        there = s.inertia * float(np.max(np.abs(s.acceleration), initial=0.0)) + float(np.max(np.abs(s.torque)))
        there += float(np.max(np.abs(s.damping), initial=0.0))
        return "its {moment} would exceed thrust, damping and {inertia} together" if taken > there > 0.0 else ""
