"""A vehicle that moves in surge, sway and yaw, with Coriolis forces between them that are known."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array
from service.recordings.recording import Recording, from_table

MASS = np.array([60.0, 80.0, 0.0, 0.0, 0.0, 12.0])
"""M, diagonal, surge to yaw [kg], [kg m²]."""
LINEAR, QUADRATIC = np.array([20.0, 35.0, 4.0]), np.array([40.0, 90.0, 10.0])
LARGEST = np.array([60.0, 60.0, 8.0])
"""The forces [N] and the torque [N m] are drawn up to these."""
PLACES = (0, 1, 5)
STEP, HELD = 0.05, 60
NAMES = ("surge", "sway", "yaw_rate", "surge_force", "sway_force", "torque")


def damping(velocity: Array) -> Array:
    """d, (3,) at u, v, r: each of its own velocity."""
    return np.asarray(LINEAR * velocity + QUADRATIC * velocity * np.abs(velocity))


def whole_vehicle(seed: int, count: int) -> Recording:
    """So many rows at 20 Hz."""
    random = np.random.default_rng(seed)
    force = np.repeat(random.uniform(-1.0, 1.0, (count // HELD + 1, 3)) * LARGEST, HELD, axis=0)[:count]
    surge, sway, yaw = MASS[list(PLACES)]

    def slope(nu: Array, tau: Array) -> Array:
        u, v, r = nu
        coriolis = np.array([-sway * v * r, surge * u * r, (sway - surge) * u * v])
        return np.asarray((tau - coriolis - damping(nu)) / np.array([surge, sway, yaw]))

    velocity = np.zeros((count, 3))
    for k in range(count - 1):
        nu, tau = velocity[k], force[k]
        middle = nu + 0.5 * STEP * slope(nu, tau)
        velocity[k + 1] = nu + STEP * slope(middle, tau)
    time: Array = STEP * np.arange(count, dtype=np.float64)
    measured = velocity + random.normal(0.0, 0.001, velocity.shape)
    return from_table("whole.csv", time, dict(zip(NAMES, [*measured.T, *force.T], strict=True)))
