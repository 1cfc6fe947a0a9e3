"""Gyros that fail without a word: one that is stuck at a value, one that is clipped at the end of its range."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.words import YAW_WORDS, AxisWords

MIN_STUCK_SAMPLES = 10
"""Samples in a row of which the duration of a stuck rate is taken."""


def check_gyro(name: str, time: Array, rate: Array, torque: Array, words: AxisWords = YAW_WORDS) -> None:
    """Refuse a gyro that was stuck or clipped.

    Args:
        name: what messages call the recording.
        time: (n,) stamps of the yaw rate [s].
        rate: (n,) [rad/s].
        torque: (n,) at the same stamps [N m].
        words: what messages call the quantities of the axis.

    Raises:
        BadInput: naming from when to when the rate stood still, or the value at which it is clipped.
    """
    if rate.size < MIN_STUCK_SAMPLES or np.ptp(rate) <= 0.0:
        return
    starts, lengths = _runs(rate)
    _check_stuck(name, time, torque, starts, lengths, words)
    _check_clipped(name, rate, starts, lengths, words)


def _runs(rate: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The begins of runs of equal values, and the number of samples of each."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(rate)) + 1])
    return starts, np.diff(np.append(starts, rate.size))


def _check_stuck(
    name: str,
    time: Array,
    torque: Array,
    starts: NDArray[np.intp],
    lengths: NDArray[np.intp],
    words: AxisWords,
    seconds: float = 5.0,  # for which a rate must stay exactly the same
    share: float = 0.1,  # of the recording that it must last as well
    # Of the torque's deviation, that meanwhile would have turned the vehicle: one at rest, or one in a steady turn seen
    # by a gyro coarser than its noise, may well show one value for long.
    driven: float = 0.3,
) -> None:
    longest = int(np.argmax(lengths))
    first, count = int(starts[longest]), int(lengths[longest])
    last = first + count - 1
    # counted in samples: within a gap of the stream nothing is known to have stood still
    lasted = count * float(np.median(np.diff(time)))
    if count < MIN_STUCK_SAMPLES or lasted <= seconds or count <= share * time.size:
        return
    if float(np.std(torque[first : last + 1])) > driven * float(np.std(torque)):
        raise BadInput(
            f"{name}: {words.rate_column} is constant from {time[first]:.6g} to {time[last]:.6g} s while the "
            f"{words.effort} varies; check the gyro, and leave these cells empty or these rows out"
        )


def _check_clipped(
    name: str,
    rate: Array,
    starts: NDArray[np.intp],
    lengths: NDArray[np.intp],
    words: AxisWords,
    in_a_row: int = 3,  # samples at the end of the range that are no coincidence
    share: float = 0.02,  # of the samples there beyond which that is none either
    stay: float = 3.0,  # at its end, in that elsewhere: a stream held between its samples repeats itself everywhere
    leap: float = 2.0,  # steps of its resolution by which a clipped rate leaves; a coarse one leaves by one
) -> None:
    levels = np.unique(rate)
    gaps = np.diff(levels)
    resolution = float(np.min(gaps[gaps > 1e-9 * (levels[-1] - levels[0])]))
    values = rate[starts]
    inner = (values > levels[0]) & (values < levels[-1])
    usual = float(np.mean(lengths[inner])) if np.any(inner) else 1.0
    for end in (levels[-1], levels[0]):
        at = np.flatnonzero((values == end) & (lengths >= in_a_row))
        clipped = int(lengths[at].sum())
        if clipped <= share * rate.size or clipped < stay * usual * at.size:
            continue
        beside = np.concatenate([values[at[at > 0] - 1], values[at[at < values.size - 1] + 1]])
        if beside.size and float(np.mean(np.abs(beside - end))) > leap * resolution:
            raise BadInput(
                f"{name}: {words.rate_column} is clipped at {end:.4g} {words.rate_unit}, where it stays for "
                f"{100 * clipped / rate.size:.0f} % of the samples; set the gyro to a wider range, or turn more slowly"
            )
