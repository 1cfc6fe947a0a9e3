"""The shortest step of time between two values of one stream, or two points of one plan."""

from __future__ import annotations

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array

MIN_STEP_S = 5e-10
"""Shortest step between two instants [s]: no clock counts finer than nanoseconds, and a slope over less is none."""


def refuse_steps(time: Array, what: str) -> None:
    """Refuses (n,) times [s], not decreasing, of which two differ by less than MIN_STEP_S; `what` names them.

    Raises:
        BadInput: naming the two times.
    """
    step = np.diff(time)
    near = np.flatnonzero((step > 0.0) & (step < MIN_STEP_S))
    if near.size:
        first, second = time[near[0]], time[near[0] + 1]
        raise BadInput(
            f"{what}: {float(first)!r} and {float(second)!r} s are less than a nanosecond apart, which no clock tells; "
            "correct the times, in seconds"
        )
