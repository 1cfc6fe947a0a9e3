"""Vehicles of the world as values: mass, damping and thrusters in six degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from simulator import leng

NAMES = tuple(AXES)
YAW = NAMES.index("yaw")
DRAG_AT_FULL_RATE = 0.9
"""In full torques: so that full torque just exceeds what the full rate takes."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle. M ν̇ + C(ν) ν + D(ν) ν + g(η) = τ, with ν through the water (Fossen 2011, Eq. 8.2).

    Attributes:
        moves: names of the axes that move; the others are held at zero.
        mass: M (6, 6), with added mass [kg], [kg m], [kg m²].
        linear, quadratic: (6,) damping of each axis [N s/m], [N s²/m²], and so on.
        effort: axis → the largest effort of its commands [N], [N m].
        righting: moment of weight and buoyancy about roll and pitch [N m].
        crossed: (axis, a, b) → X of the damping X |a| b.
        curve: r [rad/s] → drag about yaw [N m], in place of the linear and quadratic one; None for those.
        bandwidth: natural frequency of its heading control when well tuned [rad/s].
        hold_s: how long a command of an open loop holds, shortest and longest [s].
    """

    moves: tuple[str, ...]
    mass: Array
    linear: Array
    quadratic: Array
    effort: Mapping[str, float]
    righting: float = 0.0
    crossed: Mapping[tuple[str, str, str], float] = field(default_factory=dict)
    curve: Callable[[float], float] | None = None
    bandwidth: float = 0.5
    hold_s: tuple[float, float] = (3.0, 9.0)

    @property
    def inertia(self) -> float:
        """I about yaw [kg m²]."""
        return float(self.mass[YAW, YAW])

    @property
    def torque(self) -> float:
        """The largest moment about yaw [N m]; of a vehicle without one, what its drag takes at 1 rad/s."""
        return self.effort.get("yaw", self.drag(1.0))

    def drag(self, rate: float) -> float:
        """d(r) [N m] of yaw alone."""
        if self.curve is not None:
            return self.curve(rate)
        return float(self.linear[YAW] * rate + self.quadratic[YAW] * rate * abs(rate))

    @property
    def rate(self) -> float:
        """The yaw rate at which the drag takes DRAG_AT_FULL_RATE of the largest moment [rad/s]."""
        low, high = 0.0, 20.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.drag(middle) < DRAG_AT_FULL_RATE * self.torque else (low, middle)
        return high

    @property
    def time(self) -> float:
        """I r/τ: how long full torque takes to the full rate without drag [s]."""
        return self.inertia * self.rate / self.torque

    @property
    def linear_drag(self) -> float:
        """d'(0) [N m s/rad]."""
        return self.drag(1e-6) / 1e-6

    def damping(self, rate: Array) -> Array:
        """d(r) [N m] at yaw rates (n,) [rad/s]."""
        return np.array([self.drag(each) for each in np.asarray(rate).tolist()])


def turning(
    inertia: float,
    torque: float,
    bandwidth: float,
    linear: float = 0.0,
    quadratic: float = 0.0,
    curve: Callable[[float], float] | None = None,
) -> Vehicle:
    """A vehicle that turns about its vertical axis alone."""
    return Vehicle(
        ("yaw",), np.diag([1.0, 1.0, 1.0, 1.0, 1.0, inertia]), _at_yaw(linear), _at_yaw(quadratic), {"yaw": torque},
        curve=curve, bandwidth=bandwidth,
    )  # fmt: skip


def _at_yaw(value: float) -> Array:
    found = np.zeros(6)
    found[YAW] = value
    return found


def shaped(inertia: float, rate: float, time: float, shape: Callable[[float], float]) -> Vehicle:
    """A vehicle that turns, from its full rate [rad/s], its time scale I R/τ [s] and its drag's shape over r/R."""
    torque = inertia * rate / time
    drag = DRAG_AT_FULL_RATE * torque
    return turning(inertia, torque, 0.6 / time, curve=lambda r: drag * shape(r / rate))


def crisis(x: float) -> float:
    """Linear and quadratic, until the boundary layer turns turbulent and a third of the quadratic part is lost."""
    return (0.35 * x + 0.8 * x * abs(x) * (1.0 - 0.35 / (1.0 + math.exp(-(abs(x) - 0.6) / 0.12)))) / 1.13


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


def stalling_fins(x: float) -> float:
    """Fins whose lift opposes the turn stall: drag that rises ever less."""
    return math.asinh(3.0 * x) / math.asinh(3.0)


TURNING = {
    "auv": turning(24.0, 18.0, 0.7, 9.0, 26.0),
    "rov": turning(0.6, 8.0, 1.8, 0.6, 1.6),
    "leng": turning(leng.INERTIA, 100.0, 0.35, curve=leng.damping),
    "small": shaped(1.0, 1.8, 0.3, crisis),
}
"""Vehicles that turn, of four sizes: those that the first list of effects is hidden in."""
SECOND = {
    "micro_rov": shaped(0.6, 1.6, 0.4, stribeck),
    "torpedo": shaped(14.0, 0.5, 1.2, stalling_fins),
    "catamaran": shaped(250.0, 0.45, 5.0, two_slopes),
    "work_rov": shaped(1500.0, 0.6, 2.5, lopsided),
}
"""Those of the second list, whose curves are no polynomials."""


def rov(rng: np.random.Generator) -> Vehicle:
    """A small ROV with eight thrusters, all axes driven."""
    mass = np.diag([18.0, 24.0, 28.0, 0.28, 0.32, 0.6]) * _draw(rng)
    mass[0, 4] = mass[4, 0] = 0.4 * rng.uniform(0.5, 1.5)
    mass[1, 3] = mass[3, 1] = -0.4 * rng.uniform(0.5, 1.5)
    linear = np.array([8.0, 12.0, 14.0, 0.3, 0.4, 0.5]) * _draw(rng)
    quadratic = np.array([35.0, 60.0, 75.0, 0.5, 0.6, 0.9]) * _draw(rng)
    effort = {"surge": 40.0, "sway": 40.0, "heave": 40.0, "roll": 2.0, "pitch": 2.0, "yaw": 4.0}
    righting = 4.0 * rng.uniform(0.8, 1.2)
    return Vehicle(NAMES, mass, linear, quadratic, effort, righting, bandwidth=1.5, hold_s=(0.6, 3.0))


def torpedo(rng: np.random.Generator) -> Vehicle:
    """A torpedo of 1.6 m in the horizontal plane, driven along surge, and by lateral and yaw thrusters."""
    mass = np.diag([32.0, 66.0, 66.0, 0.3, 8.0, 8.0]) * _draw(rng)
    mass[1, 5] = mass[5, 1] = 1.5 * rng.uniform(-1.0, 1.0)
    linear = np.array([3.0, 18.0, 18.0, 0.5, 5.0, 5.0]) * _draw(rng)
    quadratic = np.array([4.0, 120.0, 120.0, 0.5, 30.0, 30.0]) * _draw(rng)
    effort = {"surge": 12.0, "sway": 25.0, "yaw": 8.0}
    return Vehicle(("surge", "sway", "yaw"), mass, linear, quadratic, effort, bandwidth=0.8, hold_s=(2.0, 10.0))


def boat(rng: np.random.Generator) -> Vehicle:
    """A boat with two thrusters, whose sway nothing drives."""
    mass = np.diag([45.0, 80.0, 1.0, 1.0, 1.0, 25.0]) * _draw(rng)
    mass[1, 5] = mass[5, 1] = 3.0 * rng.uniform(-1.0, 1.0)
    linear = np.array([8.0, 60.0, 1.0, 1.0, 1.0, 15.0]) * _draw(rng)
    quadratic = np.array([12.0, 150.0, 1.0, 1.0, 1.0, 60.0]) * _draw(rng)
    effort = {"surge": 60.0, "yaw": 18.0}
    return Vehicle(("surge", "sway", "yaw"), mass, linear, quadratic, effort, bandwidth=0.7, hold_s=(1.0, 6.0))


BODIES = {"rov": rov, "torpedo": torpedo, "boat": boat}
"""Whole vehicles, whose sizes are drawn."""


def _draw(rng: np.random.Generator) -> Array:
    return rng.uniform(0.7, 1.3, 6)
