"""Five vehicles, from one that two hands lift to a barge, each with a drag curve of its own shape.

A curve is the drag over its value at the full rate, as a function of x = r/R: zero at zero, against the motion
everywhere (x d(x) > 0), and none is a polynomial in x and |x|.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

from simulator.second.plant import Curve

DRAG_AT_FULL_RATE = 0.9
"""Drag at the full rate, in the full torque, so that full torque just reaches the full rate."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """How large and how fast a vehicle is.

    Attributes:
        inertia: the declared moment of inertia with its added mass, I [kg m²].
        full_rate: R, the yaw rate that full torque holds [rad/s].
        time_scale: T, in which full torque without drag would bring it to the full rate [s].
        shape: x = r/R -> drag over that at the full rate.
    """

    inertia: float
    full_rate: float
    time_scale: float
    shape: Callable[[float], float]

    @property
    def full_torque(self) -> float:
        """I R/T [N m]."""
        return self.inertia * self.full_rate / self.time_scale

    def drag(self) -> Curve:
        """d(r): r [rad/s] -> N m."""
        shape, rate, moment = self.shape, self.full_rate, DRAG_AT_FULL_RATE * self.full_torque
        return lambda r: moment * shape(r / rate)


def stribeck(x: float) -> float:
    """A hump at slow motion, where laminar flow still clings, upon drag that rises: Stribeck's shape, no stiction."""
    hump = x / 0.3 * math.exp(0.5 - 0.5 * (x / 0.3) ** 2)
    return 0.25 * hump + 0.965 * math.copysign(abs(x) ** 1.6, x)


def lopsided(x: float) -> float:
    """A hull with its sensor head to one side: drag of another power and size in either direction."""
    return 0.92 * math.pow(x, 1.35) if x > 0.0 else -1.1 * math.pow(-x, 1.6)


def two_slopes(x: float) -> float:
    """Attached flow up to half the full rate, separated beyond, with a soft knee between the two slopes."""
    knee, width = 0.5, 0.06
    beyond = width * (math.log1p(math.exp((abs(x) - knee) / width)) - math.log1p(math.exp(-knee / width)))
    return math.copysign(0.55 * abs(x) + 0.9 * beyond, x)


_TANK_RATES = (0.0, 0.08, 0.2, 0.32, 0.45, 0.6, 0.75, 0.9, 1.1, 1.5)
_TANK_DRAGS = (0.0, 0.03, 0.11, 0.16, 0.22, 0.37, 0.58, 0.82, 1.18, 1.9)


def tank_table(x: float) -> float:
    """Lines between the points of a towing tank, which dip where the boundary layer turns turbulent."""
    size = abs(x)
    cell = min(bisect_right(_TANK_RATES, size), len(_TANK_RATES) - 1) - 1
    slope = (_TANK_DRAGS[cell + 1] - _TANK_DRAGS[cell]) / (_TANK_RATES[cell + 1] - _TANK_RATES[cell])
    return math.copysign(_TANK_DRAGS[cell] + slope * (size - _TANK_RATES[cell]), x)


def stalling_fins(x: float) -> float:
    """Fins whose lift opposes the turn stall: drag that rises ever less."""
    return math.asinh(3.0 * x) / math.asinh(3.0)


VEHICLES = {
    "micro_rov": Vehicle(inertia=0.6, full_rate=1.6, time_scale=0.4, shape=stribeck),
    "torpedo": Vehicle(inertia=14.0, full_rate=0.5, time_scale=1.2, shape=stalling_fins),
    "catamaran": Vehicle(inertia=250.0, full_rate=0.45, time_scale=5.0, shape=two_slopes),
    "work_rov": Vehicle(inertia=1500.0, full_rate=0.6, time_scale=2.5, shape=lopsided),
    "barge": Vehicle(inertia=4000.0, full_rate=0.12, time_scale=15.0, shape=tank_table),
}
