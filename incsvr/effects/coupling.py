"""A moment that follows another channel."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class Coupling(Effect):
    """c (x − x₀) for any further channel x: N_v v of sway, the gyroscopic moment of roll, a winch's current.

    A channel that passes through zero (a speed, a rate) acts from there, x₀ = 0. One that never does (a voltage, a
    depth) acts by its difference from a reference that only the data know: a second column places it.
    """

    sentence = (
        "a {name} {moment} follows another channel (hydrodynamic coupling as N_v, or an actuator of another axis)"
    )
    source = (
        "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 7 (coupled 6-DOF model)"
    )
    equation = "I ṙ + d(r) = τ + c (x − x₀)"
    shown_by = "several values of the channel at the same {effort} and {rate}"
    acts = "outside"

    def __init__(self, channel: str) -> None:
        self.name = f"coupling:{channel}"
        self.channels = (channel,)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        values = s.channels[self.channels[0]]
        low, high = (float(q) for q in np.quantile(values, [0.01, 0.99]))
        return [(0.0,)] if low <= 0.0 <= high else [(float(np.mean(values)),)]

    def width(self, inner: tuple[float, ...]) -> int:
        return 1 if inner[-1] == 0.0 else 2

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        away = s.channels[self.channels[0]] - inner[-1]
        return stack(-away) if inner[-1] == 0.0 else stack(-away, -np.ones_like(away))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        slope, *offset = term.coefficients
        if not offset or not slope:
            return {"coefficient": slope}
        return {"coefficient": slope, "reference": term.inner[-1] - offset[0] / slope}

    def implausible(self, term: Term, s: Signals) -> str:
        moment = abs(term.coefficients[0]) * float(np.std(s.channels[self.channels[0]]))
        largest = float(np.max(np.abs(s.torque))) + float(np.max(np.abs(s.damping))) if s.damping.size else np.inf
        return "its {moment} would exceed thrust and damping" if moment > largest > 0.0 else ""
