"""A moment that follows another channel."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Coupling(Effect):
    """c (x − x̄) + offset for any further channel x: N_v v of sway, the gyroscopic moment of roll, a winch's current."""

    sentence = "a yaw moment follows another channel (hydrodynamic coupling as N_v, or an actuator of another axis)"
    source = (
        "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 7 (coupled 6-DOF model)"
    )
    acts = "outside"

    def __init__(self, channel: str) -> None:
        self.name = f"coupling:{channel}"
        self.channels = (channel,)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(np.mean(s.channels[self.channels[0]])),)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        away = s.channels[self.channels[0]] - inner[-1]
        return stack(-away, -np.ones_like(away))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        slope, offset = term.coefficients
        return {"coefficient": slope, "moment_at_zero_nm": offset - slope * term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        moment = abs(term.coefficients[0]) * float(np.std(s.channels[self.channels[0]]))
        largest = float(np.max(np.abs(s.torque))) + float(np.max(np.abs(s.damping))) if s.damping.size else np.inf
        return "its moment would exceed thrust and damping" if moment > largest > 0.0 else ""
