"""Gyros that fail without a word: one that is stuck at a value, one that is clipped at the end of its range."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array

STUCK = 5.0
"""How long a rate must stay exactly the same to be called stuck [s]."""

STUCK_PART = 0.1
"""Part of the recording that it must last as well."""

MOVED = 0.3
"""Deviation of the torque meanwhile, in that of the whole recording, that would have turned the vehicle: a vehicle at
rest, or one in a steady turn seen by a gyro coarser than its noise, may well show one value for long."""

CLIPPED_PART = 0.02
"""Part of the samples at the very end of the range beyond which that is no coincidence."""

PILED = 3.0
"""How much longer than elsewhere the rate stays at its end: a stream that was held between its samples repeats itself
everywhere."""

LEAPT = 2.0
"""Steps of the gyro's resolution by which a clipped rate leaves its end. One that is merely coarse leaves by one."""

SEVERAL = 3
"""Samples in a row that are no coincidence."""

FEWEST = 10
"""Samples in a row of which a duration is taken."""


def check_gyro(name: str, time: Array, rate: Array, torque: Array) -> None:
    """Refuse a gyro that was stuck or clipped.

    Args:
        name: what messages call the recording.
        time: (n,) stamps of the yaw rate [s].
        rate: (n,) [rad/s].
        torque: (n,) at the same stamps [N m].

    Raises:
        BadInput: naming from when to when the rate stood still, or the value at which it is clipped.
    """
    if rate.size < FEWEST or np.ptp(rate) <= 0.0:
        return
    starts, lengths = _runs(rate)
    _check_stuck(name, time, torque, starts, lengths)
    _check_clipped(name, rate, starts, lengths)


def _runs(rate: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where runs of equal values begin, and how many samples each has."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(rate)) + 1])
    return starts, np.diff(np.append(starts, rate.size))


def _check_stuck(name: str, time: Array, torque: Array, starts: NDArray[np.intp], lengths: NDArray[np.intp]) -> None:
    longest = int(np.argmax(lengths))
    first, count = int(starts[longest]), int(lengths[longest])
    last = first + count - 1
    # counted in samples: within a gap of the stream nothing is known to have stood still
    lasted = count * float(np.median(np.diff(time)))
    if count < FEWEST or lasted <= STUCK or count <= STUCK_PART * time.size:
        return
    if float(np.std(torque[first : last + 1])) > MOVED * float(np.std(torque)):
        raise BadInput(
            f"{name}: yaw_rate stands still from {time[first]:.6g} to {time[last]:.6g} s while the torque varies; "
            "check the gyro, and leave these cells empty or these rows out"
        )


def _check_clipped(name: str, rate: Array, starts: NDArray[np.intp], lengths: NDArray[np.intp]) -> None:
    levels = np.unique(rate)
    gaps = np.diff(levels)
    resolution = float(np.min(gaps[gaps > 1e-9 * (levels[-1] - levels[0])]))
    values = rate[starts]
    inner = (values > levels[0]) & (values < levels[-1])
    usual = float(np.mean(lengths[inner])) if np.any(inner) else 1.0
    for end in (levels[-1], levels[0]):
        at = np.flatnonzero((values == end) & (lengths >= SEVERAL))
        clipped = int(lengths[at].sum())
        if clipped <= CLIPPED_PART * rate.size or clipped < PILED * usual * at.size:
            continue
        beside = np.concatenate([values[at[at > 0] - 1], values[at[at < values.size - 1] + 1]])
        if beside.size and float(np.mean(np.abs(beside - end))) > LEAPT * resolution:
            raise BadInput(
                f"{name}: yaw_rate is clipped at {end:.4g} rad/s, where it stays for {100 * clipped / rate.size:.0f} % "
                "of the samples; set the gyro to a wider range, or turn more slowly"
            )
