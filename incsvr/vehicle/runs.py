"""The recordings of a vehicle as the engine takes them: what all of them have, without long pauses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.model.series import together, without_pauses
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES

ANGLES = ("roll", "pitch", "heading")
"""φ, θ and ψ [rad] as recordings call them."""
MIN_SAMPLES = 20
"""Samples of the slowest velocity in the shortest stretch that is fitted: a shorter one contains hardly a window."""
HELD_SHARE = 0.3
"""Share of values that repeat the one before, from which an effort is a command that is constant until the next one."""


def prepared(runs: Sequence[Streams]) -> list[Streams]:
    """The stretches without pauses, each with the velocities, efforts and angles that every run has.

    A velocity that never changes is left out: a column of zeros was not measured.

    Raises:
        BadInput: no velocity is in every run, or no stretch is long enough.
    """
    names = (*VELOCITIES, *EFFORTS, *ANGLES)
    recorded = [name for name in names if all(name in run and run[name][0].size > 1 for run in runs)]
    constant = [name for name in VELOCITIES if name in recorded and not any(np.ptp(run[name][1]) for run in runs)]
    recorded = [name for name in recorded if name not in constant]
    velocities = [name for name in recorded if name in VELOCITIES]
    if not velocities:
        raise BadInput(
            "no velocity that changes is in every recording; name them: --column surge=NAME --column yaw_rate=NAME"
        )
    common = [together({name: run[name] for name in recorded}) for run in runs]
    parts = [part for run in common if _whole(run) for part in without_pauses(run, recorded, 5.0) if _whole(part)]
    found = [part for part in parts if min(part[name][0].size for name in velocities) > MIN_SAMPLES]
    if not found:
        raise BadInput(
            "no stretch without gaps is long enough; give longer recordings, in which all velocities and efforts come "
            "together"
        )
    return found


def axes_of(runs: Sequence[Streams]) -> tuple[str, ...]:
    """Names of the axes whose velocity every run has, in the order of ν."""
    return tuple(axis.name for axis in AXES.values() if all(axis.rate in run for run in runs))


def largest(runs: Sequence[Streams], names: Sequence[str]) -> Array:
    """(n,) the largest size of each stream; 0 of one that is not there."""
    found = [[np.abs(run[name][1]).max() for run in runs if name in run] for name in names]
    return np.array([max(each, default=0.0) for each in found])


def is_held(values: Array) -> bool:
    """Whether values are those of a command, which repeats itself until it changes."""
    moved = values[values != 0.0]
    return moved.size > 1 and float(np.mean(np.diff(moved) == 0.0)) >= HELD_SHARE


def _whole(run: Streams) -> bool:
    """Whether every stream moves on."""
    return all(time.size > 1 for time, _ in run.values())
