"""A torque that comes too slowly for the vehicle is said; one that is sent on change, or comes often enough, is not."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.message_rates import slow_torque

TIME = np.arange(0.0, 200.0, 0.05, dtype=np.float64)


def held(seed: int, longest: float = 2.0) -> tuple[Array, Array]:
    """Instants and levels of a command."""
    random = np.random.default_rng(seed)
    at = np.cumsum(random.uniform(0.3, longest, 400))
    return at[at < TIME[-1]], random.uniform(-1.0, 1.0, 400)[: np.count_nonzero(at < TIME[-1])]


def turning(at: Array, levels: Array) -> Array:
    """A yaw rate that follows the levels within a quarter of a second."""
    command = levels[np.clip(np.searchsorted(at, TIME, side="right") - 1, 0, None)]
    rate = np.zeros(TIME.size)
    for k in range(1, TIME.size):
        rate[k] = rate[k - 1] + 0.2 * (command[k - 1] - rate[k - 1])
    return rate


def test_what_is_sent_on_change_is_known_between() -> None:
    at, levels = held(780101)
    assert slow_torque((TIME, turning(at, levels)), (at, levels)) is None


def test_noise_of_a_gyro_says_nothing_of_how_fast_a_vehicle_is() -> None:
    """It changes from sample to sample: that asked for a torque at 501 Hz."""
    noise = np.random.default_rng(780102).normal(0.0, 0.005, TIME.size)
    told = np.random.default_rng(780103).uniform(-1.0, 1.0, TIME.size)
    assert slow_torque((TIME, noise), (TIME, told)) is None
