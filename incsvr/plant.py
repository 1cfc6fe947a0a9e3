"""The vehicle about its vertical axis: I ṙ + d(r) = τ, its thrusters and the damping moment (Eq. 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil

import numpy as np

from incsvr.samples import Array

Damping = Callable[[float], float]
"""d(r): a yaw rate [rad/s] → the damping moment [N m]."""


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


def damping_moment(torque: Array, yaw_acceleration: Array, inertia: float) -> Array:
    """d = τ − I ṙ (Eq. 5), (n,) [N m], from τ (n,) [N m], ṙ (n,) [rad/s²] and I [kg m²]."""
    return torque - inertia * yaw_acceleration


def free_run(
    time: Array, torque: Array, yaw_rate: float, *, inertia: float, damping: Damping, max_step: float = 0.05
) -> Array:
    """The yaw rate simulated from the torque alone, I ṙ = τ − d(r), (n,) [rad/s], by Runge–Kutta steps.

    A simulation that runs away, because d(r) feeds energy in, is NaN from there on.

    Args:
        time: (n,) stamps [s], strictly increasing.
        torque: (n,) τ [N m], linear between the stamps.
        yaw_rate: the first yaw rate [rad/s].
        inertia: I [kg m²].
        damping: d(r), of one number.
        max_step: longest step [s].
    """
    result = np.full(time.size, np.nan)
    if time.size == 0:
        return result
    rate = result[0] = float(yaw_rate)
    bound = 1e3 * max(1.0, abs(rate))
    stamps, moments = time.tolist(), torque.tolist()
    for k in range(1, time.size):
        whole = stamps[k] - stamps[k - 1]
        count = max(1, ceil(whole / max_step - 1e-9))
        step, rise = whole / count, (moments[k] - moments[k - 1]) / count
        for part in range(count):
            before = moments[k - 1] + part * rise
            middle, after = before + 0.5 * rise, before + rise
            k1 = (before - damping(rate)) / inertia
            k2 = (middle - damping(rate + 0.5 * step * k1)) / inertia
            k3 = (middle - damping(rate + 0.5 * step * k2)) / inertia
            k4 = (after - damping(rate + step * k3)) / inertia
            rate += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if not abs(rate) < bound:
            break
        result[k] = rate
    return result


def tabulated(damping: Callable[[Array], Array], limit: float, nodes: int = 4001) -> Damping:
    """d(r) of one number for `free_run`, linear between `nodes` rates within ±limit [rad/s], asked itself beyond.

    With R = limit it is off by at most (R/(nodes − 1))² max|d″|/2: 8e-5 N m for R = 0.5 rad/s and a d″ of 10⁴ N m s².
    """
    rates = np.linspace(-limit, limit, nodes)
    values: list[float] = damping(rates).tolist()
    scale = (nodes - 1) / (2.0 * limit)

    def drag(rate: float) -> float:
        place = (rate + limit) * scale
        if not 0.0 <= place < nodes - 1:
            return float(damping(np.array([rate]))[0])
        cell = int(place)
        return values[cell] + (place - cell) * (values[cell + 1] - values[cell])

    return drag
