"""The noise of the recordings: of gyro and torque, and which part of the equation's noise turned the vehicle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from incsvr.effects import Signals
from incsvr.tracer.run import Array, Run, stream
from incsvr.tracer.weak_form import Blocks, despiked


def gyro_noise(runs: Sequence[Run]) -> float:
    """Deviation of the yaw rate's white noise [rad/s], from its third differences (which no motion survives)."""
    third = np.concatenate([np.diff(stream(run, run.yaw_rate)[1], 3) for run in runs])
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))


def white_noise(runs: Sequence[Run]) -> float:
    """Deviation of the torque's white noise [N m], from its third differences."""
    third = np.concatenate([np.diff(despiked(stream(run, run.torque)[1]), 3) for run in runs])
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))


def torque_scatter(runs: Sequence[Run], block: float) -> float:
    """Deviation of the torque samples within a block of that many seconds that no motion follows [N m]."""
    period = float(np.median(np.concatenate([np.diff(stream(run, run.torque)[0]) for run in runs])))
    return white_noise(runs) * float(np.sqrt(max(1.0 - period / block, 0.0)))


def noise_share(blocks: Blocks, torque: Array, residual: Array) -> float:
    """Which part of the equation's noise sits in the recorded torque, 0…1.

    With e = n − w (torque noise n, disturbance in the water w) and both cut to their fastest part by third differences,
    where no excitation is left but steps: cov(F e, F τ)/var(F e) = var n/(var n + var w). Blocks with a step of the
    command, which stand out of F τ, are left out.
    """
    torque = blocks.mean(torque)
    kernel = np.array([1.0, -3.0, 3.0, -1.0])
    fast_e, fast_t = [], []
    for a, b in zip(blocks.start[:-1], blocks.start[1:], strict=True):
        if b - a > 4:
            fast_e.append(np.convolve(residual[a:b], kernel, "valid"))
            fast_t.append(np.convolve(torque[a:b], kernel, "valid"))
    e, t = np.concatenate(fast_e), np.concatenate(fast_t)
    calm = (np.abs(t) <= 4.0 * 1.4826 * float(np.median(np.abs(t))) + 1e-12) & (
        np.abs(e) <= 4.0 * 1.4826 * float(np.median(np.abs(e))) + 1e-12
    )
    power = float(e[calm] @ e[calm])
    return float(np.clip((e[calm] @ t[calm]) / power, 0.0, 1.0)) if power > 0.0 else 0.0


def calmed(signals: Signals, size: int) -> Array:
    """(n,) running median of the torque over a block."""
    pieces = [median_filter(signals.torque[run], size | 1, mode="nearest") for run in signals.runs()]
    return np.concatenate(pieces)


def foretell(torque: Array, blocks: Blocks, order: int = 6) -> Array:
    """(n_b,) each block's mean torque from the six blocks before it by least squares; near a run's start the last."""
    position = np.arange(torque.size) - np.repeat(blocks.start[:-1], np.diff(blocks.start))
    usable = np.flatnonzero(position >= order)
    past = np.stack([torque[usable - k] for k in range(1, order + 1)], axis=1)
    ridge = 1e-6 * float(np.sum(past**2)) + 1e-300
    weights = np.linalg.solve(past.T @ past + ridge * np.eye(order), past.T @ torque[usable])
    foretold = np.where(position > 0, np.concatenate([[0.0], torque[:-1]]), torque)
    foretold[usable] = past @ weights
    return foretold
