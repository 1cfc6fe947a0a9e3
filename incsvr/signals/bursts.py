"""A stream whose values are stamped when they are sent or written together, and not when they were measured."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array

SHORT_STEP_SHARE = 0.25
"""Step between two values, as a share of the mean step, below which it is one within a burst: in bursts most are. Of
values that come at random times a fifth is."""
MAX_HARMLESS_GAP_S = 0.1
"""Time between two bursts up to which they do no harm [s]: few vehicles move within it, and the commands of several
thrusters come together."""
PAUSE_SHARE = 0.005
"""Share of the steps that may be pauses of the stream, which say nothing of how it comes otherwise."""


def bursts(stamps: Array) -> float | None:
    """The time between two bursts [s] where a stream (n,) [s] comes in them; None where it does not."""
    steps = np.sort(np.diff(stamps))
    steps = steps[: steps.size - int(PAUSE_SHARE * steps.size)]
    if steps.size < 8:
        return None
    mean = float(steps.mean())
    between = steps[steps > SHORT_STEP_SHARE * mean]
    if between.size == 0 or between.size > steps.size // 2:
        return None
    apart = float(np.median(between))
    return apart if apart > MAX_HARMLESS_GAP_S else None


def in_bursts(name: str, apart: float) -> str:
    """The sentence for people, with the cure."""
    return (
        f"the {name} arrives in bursts {apart:.2g} s apart, stamped when sent or written: the time of each measurement "
        "is unknown; stamp each value where it is measured"
    )
