"""Free runs of one axis, by Heun's method, whose damping goes by other velocities too: these are as measured."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np

from incsvr.free_run.integrator import MAX_STEP_S, RUNAWAY_RATES
from incsvr.free_run.motions import Motion
from incsvr.learning.model import Model
from incsvr.numerics import Array, Streams


def free_run_errors(runs: Sequence[tuple[Motion, Streams]], inertia: float, model: Model) -> list[Array]:
    """(m,) simulated minus measured yaw rate of each run [rad/s], NaN from where it runs away.

    Args:
        runs: each with the streams of its recording, name → (stamps [s], values).
        inertia: I [kg m²].
        model: trained over several velocities.
    """
    if model.several is None:
        return []
    errors = []
    for motion, streams in runs:
        others = [streams[name] for name in model.several.others]

        def simulate(
            time: Array,
            torque: Array,
            first: float,
            others: Sequence[tuple[Array, Array]] = others,
            motion: Motion = motion,
        ) -> Array:
            beside = np.column_stack([np.interp(time, *stream) for stream in others])
            linear = None if motion.linear is None else np.interp(time, motion.torque_time, motion.linear)
            return free_run(time, torque, first, beside, linear, inertia, model)

        errors.append(motion.error(simulate))
    return errors


def free_run(
    time: Array, torque: Array, first: float, beside: Array, linear: Array | None, inertia: float, model: Model
) -> Array:
    """The rate simulated from the torque and the other velocities, I ṙ = τ − d(r, ν) − b r, (n,) [rad/s].

    Args:
        time: (n,) stamps [s], strictly increasing.
        torque: (n,) τ [N m], linear between the stamps.
        first: the first rate [rad/s].
        beside: (n, d − 1) the other velocities, likewise.
        linear: (n,) b [N m s]; None for none.
        inertia, model: as of `free_run_errors`.
    """
    several = model.several
    assert several is not None
    found, slope = np.full(time.size, np.nan), np.zeros(time.size) if linear is None else linear
    driven = np.column_stack((torque, slope, beside))
    rate = found[0] = first

    def rising(rate: float, now: Array) -> float:
        velocity = np.concatenate(([rate], now[2:]))[None, :]
        damping = float(several.value(velocity, model.gamma, model.weight)[0])
        return float(now[0] - damping - now[1] * rate) / inertia

    for k in range(1, time.size):
        count = max(1, ceil((time[k] - time[k - 1]) / MAX_STEP_S - 1e-9))
        step, change = float(time[k] - time[k - 1]) / count, (driven[k] - driven[k - 1]) / count
        for part in range(count):
            now = driven[k - 1] + part * change
            before = rising(rate, now)
            rate += 0.5 * step * (before + rising(rate + step * before, now + change))
        if not abs(rate) < RUNAWAY_RATES * max(1.0, abs(first)):
            return found
        found[k] = rate
    return found
