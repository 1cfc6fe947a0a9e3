"""Products of two velocities: found where they act, told from what a yaw tracer would name instead, absent else."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run

STEP, INERTIA, MUNK, LIFT = 0.1, 24.0, 30.0, 15.0


def wandering(random: np.random.Generator, count: int, lag: float, size: float) -> Array:
    """A velocity that wanders with this time constant [s]."""
    noise, values = random.normal(0.0, 1.0, count), np.zeros(count)
    for k in range(1, count):
        values[k] = values[k - 1] + STEP / lag * (noise[k] - values[k - 1])
    return np.asarray(size * values / np.std(values))


def boat(seed: int, munk: float = 0.0, lift: float = 0.0, count: int = 1500) -> Run:
    """Yaw of a vehicle that surges and sways: I ṙ + 9 r + 26 r|r| + munk u v + lift (u − 0.6) r = τ."""
    random = np.random.default_rng(seed)
    surge, sway = 0.6 + wandering(random, count, 4.0, 0.3), wandering(random, count, 3.0, 0.25)
    torque = np.repeat(random.uniform(-12.0, 12.0, count // 30), 30)
    water = wandering(random, count, 0.5, 0.3)
    rate = np.zeros(count)
    for k in range(count - 1):
        r = rate[k]
        for _ in range(4):
            moment = torque[k] + water[k] - 9.0 * r - 26.0 * r * abs(r)
            moment -= munk * surge[k] * sway[k] + lift * (surge[k] - 0.6) * r
            r += 0.25 * STEP / INERTIA * moment
        rate[k + 1] = r
    time: Array = STEP * np.arange(count, dtype=np.float64)
    rate += random.normal(0.0, 0.002, count)
    return Run(f"boat {seed}", time, rate, torque, {"surge": surge, "sway": sway})


def test_nothing_is_named_where_no_product_acts() -> None:
    assert trace([boat(3)], inertia=INERTIA, validate=[boat(4)]).verdict == "none"


def test_a_product_with_the_own_rate_is_told() -> None:
    """m x_g u r, by which the vehicle does not drive itself."""
    found = trace([boat(5, lift=LIFT)], inertia=INERTIA, torque="commanded")
    (own,) = found.effects
    assert "coriolis:surge*yaw_rate" in (own.effect, *own.cannot_tell_from)
