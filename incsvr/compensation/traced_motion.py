"""Free runs of a learned damping together with traced effects, against measured runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation
from incsvr.effects import Signals
from incsvr.learning.free_run import Motion
from incsvr.numerics import Array, Streams
from incsvr.tracing.model import TracedModel

STEPS_PER_SCALE = 40.0
"""Steps of the simulation in the vehicle's time scale."""


def traced_free_run_errors(
    pieces: Sequence[tuple[Motion, Streams]], compensation: Compensation, damping: Callable[[Array], Array]
) -> list[Array]:
    """(m,) simulated minus measured yaw rate of each motion [rad/s], from its first measured yaw rate with torque and
    channels.

    Args:
        pieces: each motion with the streams of its recording, name → (stamps [s], values).
        compensation: the effects.
        damping: the learned d(r), (n,) rad/s → (n,) N m.
    """
    reach = 2.0 * max((float(np.abs(motion.yaw_rate).max()) for motion, _ in pieces), default=1e-3)
    rate = np.linspace(-reach, reach, 401)
    model = replace(compensation.model, rate=rate, damping=damping(rate))
    return [_error(model, motion, streams) for motion, streams in pieces]


def _error(model: TracedModel, motion: Motion, streams: Streams) -> Array:
    """(m,) simulated minus measured yaw rate [rad/s]."""
    step = model.scale / STEPS_PER_SCALE
    time: Array = np.arange(motion.rate_time[0], motion.rate_time[-1] + 2.0 * step, step, dtype=np.float64)
    heading = np.zeros(time.size)
    if HEADING_CHANNEL in streams:
        heading = np.interp(time, streams[HEADING_CHANNEL][0], np.unwrap(streams[HEADING_CHANNEL][1]))
    signals = Signals(
        step=step, start=np.array([0, time.size], dtype=np.intp), time=time,
        rate=np.interp(time, motion.rate_time, motion.yaw_rate),
        torque=np.interp(time, motion.torque_time, motion.torque), heading=heading,
        channels={name: np.interp(time, *values) for name, values in streams.items()},
    )  # fmt: skip
    index, simulated = model.simulate(signals)
    return np.asarray(np.interp(motion.rate_time, time[index], simulated) - motion.yaw_rate)
