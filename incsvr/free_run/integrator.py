"""The yaw rate that follows from the torque alone where damping is a curve, by Runge–Kutta steps of fourth order."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np

from incsvr.numerics import Array

Damping = Callable[[float], float]
"""d(r): a yaw rate [rad/s] → the damping moment [N m]."""
MAX_STEP_S = 0.05
"""Longest step [s]: a vehicle under water hardly settles within one."""
RUNAWAY_RATES = 1e3
"""A run has run away beyond so many times its first rate, or one [rad/s] where that is slower."""


def free_run(
    time: Array,
    torque: Array,
    yaw_rate: float,
    *,
    inertia: float,
    damping: Damping,
    linear: Array | None = None,
    max_step: float = MAX_STEP_S,
) -> Array:
    """The yaw rate simulated from the torque alone, I ṙ = τ − d(r) − b r, (n,) [rad/s], by Runge–Kutta steps.

    A simulation that runs away, because d(r) feeds energy in, is NaN from there on.

    Args:
        time: (n,) stamps [s], strictly increasing.
        torque: (n,) τ [N m], linear between the stamps.
        yaw_rate: the first yaw rate [rad/s].
        inertia: I [kg m²].
        damping: d(r), of one number.
        linear: (n,) b [N m s], what other velocities make of the own one, linear between the stamps; None for none.
        max_step: longest step [s].
    """
    result = np.full(time.size, np.nan)
    if time.size == 0:
        return result
    rate = result[0] = float(yaw_rate)
    bound = RUNAWAY_RATES * max(1.0, abs(rate))
    stamps, moments = time.tolist(), torque.tolist()
    slopes = [0.0] * time.size if linear is None else linear.tolist()
    for k in range(1, time.size):
        whole = stamps[k] - stamps[k - 1]
        count = max(1, ceil(whole / max_step - 1e-9))
        step, rise = whole / count, (moments[k] - moments[k - 1]) / count
        steeper = (slopes[k] - slopes[k - 1]) / count
        for part in range(count):
            before = moments[k - 1] + part * rise
            middle, after = before + 0.5 * rise, before + rise
            first = slopes[k - 1] + part * steeper
            half, last = first + 0.5 * steeper, first + steeper
            k1 = (before - damping(rate) - first * rate) / inertia
            second = rate + 0.5 * step * k1
            k2 = (middle - damping(second) - half * second) / inertia
            third = rate + 0.5 * step * k2
            k3 = (middle - damping(third) - half * third) / inertia
            fourth = rate + step * k3
            k4 = (after - damping(fourth) - last * fourth) / inertia
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
