"""One axis by itself, I ṙ + d(r) = τ: the damping moment that the motion shows (Eq. 5)."""

from __future__ import annotations

from incsvr.numerics import Array


def damping_moment(torque: Array, yaw_acceleration: Array, inertia: float) -> Array:
    """d = τ − I ṙ (Eq. 5), (n,) [N m], from τ (n,) [N m], ṙ (n,) [rad/s²] and I [kg m²]."""
    return torque - inertia * yaw_acceleration
