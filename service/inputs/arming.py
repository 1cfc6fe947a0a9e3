"""Only while the thrusters may turn is there something to learn: the spans in which a vehicle was armed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.samples import Array
from service.inputs.settings import Armed

Spans = tuple[tuple[float, float], ...]


def spans(time: Array, armed: Array) -> Spans:
    """From when to when a vehicle was armed [s], by what was told at `time` (n,) [s]; the last word holds for ever.

    What was told first holds before it, too.
    """
    if not time.size:
        return ()
    on = armed > 0.5
    changes = np.flatnonzero(np.diff(on.astype(np.int8))) + 1
    edges = [-np.inf, *(float(time[place]) for place in changes), np.inf]
    states = [bool(on[0]), *(bool(on[place]) for place in changes)]
    return tuple((edges[k], edges[k + 1]) for k, state in enumerate(states) if state)


def says_armed(settings: Armed, values: Array) -> NDArray[np.bool_]:
    """Whether each of the values (n,) of the field says that the thrusters may turn."""
    if settings.bit is not None:
        return np.asarray((np.nan_to_num(values).astype(np.int64) & settings.bit) != 0)
    if settings.equals is not None:
        return np.asarray(values == settings.equals)
    return np.asarray(np.nan_to_num(values) != 0.0)


def within(time: Array, wanted: Spans) -> NDArray[np.bool_]:
    """Which of the instants (n,) [s] are in the spans."""
    inside = np.zeros(time.size, dtype=bool)
    for low, high in wanted:
        inside |= (time >= low) & (time < high)
    return inside
