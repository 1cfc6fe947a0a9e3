"""The motion that is evidence about damping: caused by the torque, not by the water.

A damping sample y = τ − I ṙ is d(r) − w, with w the moment of the water. Where the torque turns the vehicle, w is
noise. Where w turns it, a sample tells the water with its sign turned, and, where a controller holds the vehicle, the
controller's gain: regression in closed loop is biased (L. Ljung, System Identification, 2nd ed., ch. 13). What tells
them apart is work. Over a window the torque's work less the rise of ½ I r² is Σ y r: what damping has taken, less what
the water has put in. Damping takes work from every motion; so where Σ y r is not clearly positive the water has made
the motion. "Clearly" is Student's t of the slope of y over r through the origin, for noise of the correlation seen.

The declared inertia may be wrong, or the torque late: then a share of ṙ stays in y, as large as all damping where the
motion is quick. What of y and of r follows the rise of r from sample to sample is taken out of both first (the slope of
y over r with ṙ beside it), so that whatever inertia is declared, the same motion is evidence.

The same holds for the motion about the window's mean. Where its work is negative, at a turn held for long, the mean is
evidence and the motion about it is not: the samples stand at the mean rate then (A. Wald, Ann. Math. Stat. 11,
1940: grouping by what the errors do not know, here by time).

Nothing is known of the vehicle here but Eq. 5, and a batch needs the last samples of the one before it at most.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.noise import Mask
from incsvr.numerics import Array, independent_share
from incsvr.signals.samples import Samples

WINDOW_SAMPLES = 11
"""Samples over which work is weighed: several of the vehicle's time scales where they stand as the paper's do."""
MIN_DRIVEN_SHARE = 0.5
"""Share of a batch that the torque makes from which all of it is evidence: the water then bends the curve by less than
leaving samples out by what they say."""

CLEAR_WORK_T = 3.5
"""Student's t from which on the work is clearly positive: by chance in one window of about 300. At 3 a vehicle that
holds its station teaches half as much again; at 4 one that follows a pipeline loses a tenth of its evidence."""
HELD_MOTION_T = 1.0
"""Student's t below whose negative the motion about the mean is the water's. By chance in one window of six of noise
alone; but at the crests of the paper's experiment, where the rate moves least, in two of a thousand."""
HELD_TURNS_SHARE = 0.2
"""Share of a batch from which on, where all of it is evidence, held turns are what it consists of: in the paper's
experiment up to 0.12 are taken for it by chance, in long circles half."""
REST_MOTION_SHARE = 0.25
"""Share of its window's motion by less than which a sample's neighbourhood moves where it is at rest beside a turn, and
no evidence; a straight pass through zero, as in the paper's experiment, has 0.26."""
MIN_WINDOW_SAMPLES = 5
"""Samples from which on a window tells anything: two are taken by what is estimated, and one may be an outlier."""
TAMING_ROUNDS = 3
"""Rounds in which a window's outlier is drawn in: at first it has drawn the line towards itself."""


@dataclass(frozen=True, slots=True)
class Recent:
    """The last samples of earlier batches for the next one, fewer than WINDOW_SAMPLES."""

    yaw_rate: Array = field(default_factory=lambda: np.empty(0))  # (n,) [rad/s]
    damping: Array = field(default_factory=lambda: np.empty(0))  # (n,) [N m]


class Sifted(NamedTuple):
    """The driven samples of a batch."""

    driven: Mask  # (n,) which of its samples are evidence about damping
    yaw_rate: Array  # (n,) the rate at which each is [rad/s]: its own, or its window's mean
    recent: Recent  # for the next batch


def sift(batch: Samples, recent: Recent) -> Sifted:
    """Tells what of a batch of n ≥ 1 samples the torque has made.

    A window is centred on its sample, but within the batch and the samples before it: nothing waits for the future.
    """
    r = np.concatenate((recent.yaw_rate, batch.yaw_rate))
    y = np.concatenate((recent.damping, batch.damping))
    kept = Recent(r[1 - WINDOW_SAMPLES :], y[1 - WINDOW_SAMPLES :])
    if r.size < MIN_WINDOW_SAMPLES:  # too few to tell
        return Sifted(np.ones(len(batch), dtype=bool), batch.yaw_rate, kept)
    count = min(WINDOW_SAMPLES, r.size)
    rise = np.empty_like(r)
    rise[1:-1] = (r[2:] - r[:-2]) / 2.0
    rise[0], rise[-1] = r[1] - r[0], r[-1] - r[-2]
    whole = windows(np.array((r, y, rise)), count)
    rates, moments, rises = whole
    motion = whole[::2]
    power = _power(motion)
    apart = motion - (np.vecdot(rates, rises) / power[::-1])[..., None] * motion[::-1]
    apart_power = _power(apart)
    slopes = np.vecdot(moments, apart) / apart_power
    for _ in range(TAMING_ROUNDS):
        moments = _tamed(moments, slopes[0][:, None] * rates + slopes[1][:, None] * rises)
        slopes = np.vecdot(moments, apart) / apart_power
    worth = (count - 2) * independent_share(y - slopes[0] * r - slopes[1] * rise)
    whole[1] = moments
    work, clear = _work(_without(moments, rises, power[1]), apart[0], worth, CLEAR_WORK_T)
    near = windows(r, 3)
    moves = np.vecdot(near, near) / 3.0 >= REST_MOTION_SHARE**2 / count * np.vecdot(rates, rates)
    mean = np.add.reduce(whole, axis=-1) / count
    whole -= mean[..., None]
    left = _without(whole[:2], whole[2], _power(whole[2]))
    taken, told = _work(left[1], left[0], worth, HELD_MOTION_T)
    new = slice(recent.yaw_rate.size, None)
    driven, held = (clear & (work > 0.0) & moves)[new], (told & (taken < 0.0))[new]
    if np.count_nonzero(driven) > MIN_DRIVEN_SHARE * driven.size:
        driven = np.ones_like(driven)
        if np.count_nonzero(held) <= HELD_TURNS_SHARE * held.size:
            return Sifted(driven, batch.yaw_rate, kept)
    return Sifted(driven, np.where(held, mean[0, new], batch.yaw_rate), kept)


def _without(values: Array, others: Array, power: Array) -> Array:
    """(…, n, m) values of which what follows the others, of this power (n,), is taken, in each window."""
    return np.asarray(values - (np.vecdot(values, others) / power)[..., None] * others)


def _power(motion: Array) -> Array:
    """(…, n) sum of squares of each window; infinite where nothing moves: then nothing follows the motion."""
    power = np.vecdot(motion, motion)
    return np.where(power > 0.0, power, np.inf)


def _work(moments: Array, rates: Array, worth: float, clearly: float) -> tuple[Array, Mask]:
    """(n,) the work of (n, m) moments over rates, and whether its Student's t is beyond ± clearly."""
    work = np.vecdot(moments, rates)
    # t² = worth (Σyr)² / (Σy² Σr² − (Σyr)²), without a division.
    square = work * work
    return work, worth * square > clearly**2 * (np.vecdot(rates, rates) * np.vecdot(moments, moments) - square)


def _tamed(moments: Array, line: Array) -> Array:
    """(n, m) moments, of which the one farthest from the line in each window is as far as the second: one outlier must
    not hide what ten samples say."""
    error = moments - line
    limit = np.partition(np.abs(error), -2, axis=1)[:, -2:-1]
    clipped = np.minimum(np.maximum(error, -limit), limit)
    return np.asarray(line + clipped)


def windows(streams: Array, count: int) -> Array:
    """(…, n, count) the window of each of (…, n) samples, centred on it but at the ends, where it stays within them.

    Example:
        >>> windows(np.array([1.0, 2.0, 3.0, 4.0]), 3).tolist()
        [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]]
    """
    return np.asarray(streams.take(_places(streams.shape[-1], count), axis=-1))


@lru_cache(maxsize=16)
def _places(n: int, count: int) -> NDArray[np.intp]:
    first = np.minimum(np.maximum(np.arange(n) - count // 2, 0), n - count)
    return np.asarray(first[:, None] + np.arange(count))
