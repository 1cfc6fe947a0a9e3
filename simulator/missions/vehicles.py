"""Three sizes of vehicle that turn about their vertical axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from simulator import leng
from simulator.trial_effects import Scale

STILL = 1e-6
"""A rate at which every drag is linear [rad/s]."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle, and how briskly its autopilot is tuned.

    Attributes:
        scale: inertia, largest torque and the rate that nine tenths of this torque hold.
        drag: d(r): r [rad/s] -> N m, zero at zero.
        bandwidth: natural frequency of its heading control when well tuned [rad/s].
    """

    scale: Scale
    drag: Callable[[float], float]
    bandwidth: float

    @property
    def linear_drag(self) -> float:
        """d'(0) [N m s/rad]."""
        return self.drag(STILL) / STILL


def _linear_and_quadratic(linear: float, quadratic: float) -> Callable[[float], float]:
    return lambda rate: rate * (linear + quadratic * abs(rate))


VEHICLES = {
    "auv": Vehicle(Scale(inertia=24.0, torque=18.0, rate=0.63), _linear_and_quadratic(9.0, 26.0), bandwidth=0.7),
    "rov": Vehicle(Scale(inertia=0.6, torque=8.0, rate=1.9), _linear_and_quadratic(0.6, 1.6), bandwidth=1.8),
    "leng": Vehicle(Scale(inertia=leng.INERTIA, torque=100.0, rate=0.24), leng.damping, bandwidth=0.35),
}
