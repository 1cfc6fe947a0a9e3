"""A vehicle in the plane, whose damping couples surge, sway and yaw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.numerics import Array
from simulator import leng
from simulator.vehicles import Vehicle

PLANAR = Vehicle(
    ("surge", "sway", "yaw"),
    np.diag([900.0, 1400.0, 1.0, 1.0, 1.0, leng.INERTIA]),
    np.array([10.0, 60.0, 1.0, 1.0, 1.0, 90.0]),
    np.array([90.0, 500.0, 1.0, 1.0, 1.0, 900.0]),
    {"surge": 260.0, "sway": 90.0, "yaw": 75.0},
    crossed={
        ("yaw", "surge", "yaw"): 440.0, ("yaw", "surge", "sway"): -250.0,
        ("sway", "surge", "sway"): 230.0, ("sway", "surge", "yaw"): -250.0,
    },
    bandwidth=0.35,
    hold_s=(6.0, 20.0),
)  # fmt: skip
"""A vehicle of Leng's size with a fin at the stern, which damps a turn the more the faster the vehicle goes."""


def planar(seed: int, spread: float = 0.25) -> Vehicle:
    """A vehicle as PLANAR, each of whose sizes is drawn within this part of its usual value."""
    rng = np.random.default_rng([seed, 0])

    def draw(values: Array) -> Array:
        return values * rng.uniform(1.0 - spread, 1.0 + spread, 6)

    crossed = {key: value * rng.uniform(1.0 - spread, 1.0 + spread) for key, value in PLANAR.crossed.items()}
    return replace(
        PLANAR, mass=np.diag(draw(np.diag(PLANAR.mass))), linear=draw(PLANAR.linear),
        quadratic=draw(PLANAR.quadratic), crossed=crossed,
    )  # fmt: skip


def yaw_damping(vehicle: Vehicle, u: Array, v: Array, r: Array, with_munk: bool) -> Array:
    """d(ν) about yaw (n,) [N m] of a vehicle that moves in the plane, with or without Munk's moment."""
    velocity = {"surge": u, "sway": v, "yaw": r}
    found = vehicle.damping(r)
    for (axis, a, b), value in vehicle.crossed.items():
        if axis == "yaw":
            found = found + value * np.abs(velocity[a]) * velocity[b]
    return found + (vehicle.mass[1, 1] - vehicle.mass[0, 0]) * u * v if with_munk else found
