"""Whether the torque of recordings answers the rate: in open or in closed loop.

In open loop nothing that the rate tells beside the torque's own past foretells the torque, however wrong the model is;
a controller follows the rate, and with it the water (P. E. Caines, C. W. Chan, IEEE Trans. Autom. Control 20, 1975).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, robust_deviation
from incsvr.numerics.linear_filter import lfilter
from incsvr.tracing.run import Run, stream
from incsvr.tracing.statistics import whitened

GYRO_SIGHT_SAMPLES = 6
"""Samples of the gyro that tell whether a controller reads it."""
SURPRISE_CLIP_DEVIATIONS = 3.0
"""Usual deviations at which a surprise is cut: a turn that was asked for is no answer."""


class Loop(Enum):
    """The relation of the torque to the rate."""

    OPEN = "nothing answers the rate"
    CLOSED = "a controller answers the rate"
    OTHER_GYRO = "a controller uses another gyro than the log's, or the torque is measured with noise of its own"


def standing_time(runs: Sequence[Run]) -> float:
    """The usual time between changes of the torque [s]; within that time it responds to nothing."""
    stood = [np.empty(0)]
    for run in runs:
        at, torque = stream(run, run.torque)
        stood.append(np.diff(at[1:][np.diff(torque) != 0.0]))
    every = np.concatenate(stood)
    return float(np.median(every)) if every.size else np.inf


def answers(
    residual: Array,
    torque: Array,
    starts: NDArray[np.intp],
    cells: int = 9,  # of its past from which the torque is predicted
    means: Sequence[float] = (20.0, 100.0),  # lengths, in cells, of running means from which it is predicted besides
    least: float = 3.5,  # deviations: most open loops stay below 2, controllers reach 4 to 60
) -> float:
    """The correlation of the torque with the residual before it; 0 if chance explains it.

    Args:
        residual: (n,) what a model leaves of the torque in each cell [N m], positive where it lacks torque.
        torque: (n,) mean of each cell [N m].
        starts: (pieces + 1,) first cell of each piece, and the end.
    """
    if float(np.ptp(torque)) == 0.0:
        return 0.0
    surprise = _clipped(whitened(residual, starts))
    past = np.stack([
        *(np.roll(torque, k) for k in range(cells)),
        np.abs(torque), torque * np.abs(torque), torque**3, np.ones(torque.size),
        *(lfilter([1.0 / length], [1.0, 1.0 / length - 1.0], torque) for length in means),
    ], axis=1)  # fmt: skip
    inside = [np.arange(a + cells, b - 1) for a, b in pairwise(starts.tolist()) if b - a > 2 * cells]
    at = np.concatenate(inside) if inside else np.empty(0, dtype=np.intp)
    if at.size < 3 * past.shape[1]:
        return 0.0
    own, unforeseen = surprise[at], _unforeseen(torque[at + 1] - torque[at], past[at])
    together = float(own @ unforeseen)
    deviations = together / max(float(np.sqrt(np.sum((own * unforeseen) ** 2))), 1e-300)
    correlation = together / max(float(np.sqrt((own @ own) * (unforeseen @ unforeseen))), 1e-300)
    return correlation if deviations > least else 0.0


def of_this_gyro(
    runs: Sequence[Run],
    # Usual surprise of a changed torque to whom sees the gyro, in that to whom does not: 0.00 to 0.83 with the gyro
    # that the controller reads, 0.91 to 1.00 else.
    most: float = 0.9,
) -> bool:
    """Whether the gyro of these recordings tells beforehand what the torque will be, as where a controller reads it.

    Not so where the controller has another gyro, and where the torque is measured with noise of its own.
    """
    ratios = [ratio for run in runs if (ratio := _unforeseen_share(run)) is not None]
    return bool(ratios) and float(np.median(ratios)) < most


def _unforeseen_share(
    run: Run,
    fewest: int = 200,  # changes of the torque from which on it is told
) -> float | None:
    """The usual surprise of a changed torque to whom knows its past and the gyro before it, in that to whom lacks the
    whole gyro, or its last samples; None where the torque hardly changes."""
    (at, rate), (when, torque) = stream(run, run.yaw_rate), stream(run, run.torque)
    changed = np.flatnonzero(np.diff(torque)) + 1
    latest = np.searchsorted(at, when[changed], side="right") - 1
    which = np.arange(GYRO_SIGHT_SAMPLES, changed.size)
    which = which[latest[which] >= GYRO_SIGHT_SAMPLES]
    if which.size < fewest:
        return None
    before = [torque[changed[which - k]] for k in range(1, GYRO_SIGHT_SAMPLES)]
    past = np.stack([*before, before[0] * np.abs(before[0]), np.ones(which.size)], axis=1)
    seen = np.stack([rate[latest[which] - k] for k in range(GYRO_SIGHT_SAMPLES)], axis=1)
    if "heading" in run.channels:
        stamps, heading = stream(run, run.channels["heading"])
        angle = np.interp(when[changed[which]], stamps, np.unwrap(heading)) if stamps.size else np.zeros(which.size)
        past = np.column_stack([past, np.sin(angle), np.cos(angle)])
    wanted = torque[changed[which]]
    sights = [np.column_stack([past, seen[:, first:]]) for first in (0, GYRO_SIGHT_SAMPLES // 2, GYRO_SIGHT_SAMPLES)]
    full, late, none = (robust_deviation(_robust_residual(sight, wanted)) for sight in sights)
    return full / max(min(late, none), 1e-300)


def _robust_residual(columns: Array, values: Array) -> Array:
    """(n,) values less a linear fit to those that are no outliers."""
    left, usual = values, 0.0
    for _ in range(3):
        kept = np.abs(left) <= SURPRISE_CLIP_DEVIATIONS * usual if usual > 0.0 else np.ones(values.size, dtype=bool)
        left = values - columns @ np.linalg.lstsq(columns[kept], values[kept])[0]
        usual = robust_deviation(left)
    return np.asarray(left)


def _clipped(white: Array) -> Array:
    """(n,) white values, cut where they are outliers."""
    usual = robust_deviation(white)
    return np.clip(white, -SURPRISE_CLIP_DEVIATIONS * usual, SURPRISE_CLIP_DEVIATIONS * usual) if usual > 0.0 else white


def _unforeseen(change: Array, past: Array) -> Array:
    """(n,) the change of the torque less what its past tells, fitted robustly, cut where it is an outlier."""
    left = _robust_residual(past, change)
    usual = robust_deviation(left) or float(np.std(left))
    cut = np.clip(left, -SURPRISE_CLIP_DEVIATIONS * usual, SURPRISE_CLIP_DEVIATIONS * usual)
    # a jump that was cut leads away from the level before it: that is its past, too
    return np.asarray(cut - past @ np.linalg.lstsq(past, cut)[0])
