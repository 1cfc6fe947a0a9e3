"""Thrusters: what each gives to the yaw moment (Section IV-A)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Thruster:
    """One thruster's share in the yaw moment (Section IV-A; the formula has no number).

    Attributes:
        lever: arm of its thrust about the vertical axis, dᵢ [m].
        thrust: Kᵢ¹, thrust by rotor speed squared [N s²/rad²].
        inflow: Kᵢ², what the water's speed through the rotor takes or adds [N s²/(m rad)].
    """

    lever: float
    thrust: float
    inflow: float

    def moment(self, rotor_speed: Array, water_speed: Array) -> Array:
        """dᵢ (Kᵢ¹ ωᵢ|ωᵢ| + Kᵢ² vᵢ|ωᵢ|) [N m] at rotor speeds ωᵢ (n,) [rad/s] and water speeds vᵢ (n,) [m/s]."""
        pull = np.abs(rotor_speed)
        moment: Array = self.lever * (self.thrust * rotor_speed + self.inflow * water_speed) * pull
        return moment


def thruster_torque(
    thrusters: tuple[Thruster, ...], rotor_speeds: tuple[Array, ...], water_speeds: tuple[Array, ...]
) -> Array:
    """The yaw moment of all thrusters, τ = Σ dᵢ (Kᵢ¹ ωᵢ|ωᵢ| + Kᵢ² vᵢ|ωᵢ|), (n,) [N m].

    Args:
        thrusters: m thrusters.
        rotor_speeds: for each its ωᵢ, (n,) [rad/s].
        water_speeds: for each its vᵢ, the water's speed at the thruster along its axis, (n,) [m/s].
    """
    moments = map(Thruster.moment, thrusters, rotor_speeds, water_speeds)
    total: Array = np.sum(list(moments), axis=0)
    return total
