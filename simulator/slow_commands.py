"""A small vehicle under commands that jump every second or two, whose messages come slowly: a ROV's usual telemetry."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array
from service.recordings.recording import Recording, from_streams

INERTIA = 0.6
"""[kg m²]."""
STEP = 0.005


def damping(rate: Array) -> Array:
    """d(r) [N m]."""
    return np.asarray(0.6 * rate + 1.6 * rate * np.abs(rate))


def recording(
    seed: int, every: float, *, changes: tuple[float, float] = (0.8, 2.4), duration: float = 420.0
) -> Recording:
    """Gyro at 20 Hz beside the command, sampled on a clock of its own.

    Args:
        seed: draws commands and the gyro's noise, 0.003 rad/s.
        every: between two messages of the command [s].
        changes: it holds for between so long [s].
        duration: [s].
    """
    random = np.random.default_rng(seed)
    count = round(duration / STEP)
    command, begin = np.empty(count), 0
    while begin < count:
        end = begin + round(random.uniform(*changes) / STEP)
        command[begin:end] = round(random.uniform(-8.0, 8.0), 3)
        begin = end
    rate, rates = 0.0, np.empty(count)
    for k, torque in enumerate(command.tolist()):
        rates[k] = rate
        rate += STEP / INERTIA * (torque - (0.6 * rate + 1.6 * rate * abs(rate)))
    time: Array = STEP * np.arange(count, dtype=np.float64)
    gyro, message = round(0.05 / STEP), round(every / STEP)
    noisy = rates[::gyro] + 0.003 * random.standard_normal(rates[::gyro].size)
    streams = {
        "yaw_rate": (time[::gyro], noisy),
        "torque": (time[message // 2 :: message], command[message // 2 :: message]),
    }
    return from_streams(f"slow_{seed}", streams)
