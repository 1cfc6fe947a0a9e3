"""Thrust that depends on the speed through the water."""

from __future__ import annotations

from typing import Literal

import numpy as np

from incsvr.effects.modulation import ThrustModulation
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class ThrustSpeed(ThrustModulation):
    """a = (1 + c (x − x̄)) τ with x = |u| of a propeller, whose thrust falls with the advance speed, or x = u² of a
    rudder, whose force grows with the square of the speed past it."""

    sentence = "the thrust depends on the advance speed: a propeller's falls with it, a rudder's grows with its square"
    shown_by = "the same {effort}s at several surge velocities"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 12 (propeller, rudder)"

    def __init__(self, channel: str, variant: Literal["falls", "square"]) -> None:
        super().__init__(channel)
        self.name = "thrust_speed"
        self.variant = f"{channel} {variant}"
        self._square = variant == "square"
        self.equation = f"a = (1 + c (x − x̄)) τ with x = {'u²' if self._square else '|u|'}"

    def value(self, s: Signals) -> Array:
        speed = s.channels[self.channels[0]]
        return speed**2 if self._square else np.abs(speed)
