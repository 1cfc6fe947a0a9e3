"""The spans in which a vehicle was armed: only these are learned from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from service.inputs.settings import Armed

Spans = tuple[tuple[float, float], ...]
MAX_WHOLE_NUMBER = 2.0**53
"""The number below which flags and states are whole numbers."""


def arming_spans(time: Array, armed: Array) -> Spans:
    """The spans in which a vehicle was armed [s], by its states at `time` (n,) [s]; the last state lasts.

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
        flags = np.where(np.abs(values) < MAX_WHOLE_NUMBER, values, 0.0).astype(np.int64)
        return np.asarray((flags & settings.bit) != 0)
    if settings.equals is not None:
        return np.asarray(values == settings.equals)
    return np.asarray(np.nan_to_num(values) != 0.0)


def says_something(settings: Armed, values: Array) -> NDArray[np.bool_]:
    """Selects the values (n,) that give an armed state: a field of events has others, too."""
    if settings.equals is None or settings.disarmed is None:
        return np.isfinite(values)
    return np.asarray((values == settings.equals) | (values == settings.disarmed))


def armed_by(settings: Armed, value: float) -> bool | None:
    """Whether a value of the field says that the thrusters may turn; None where it says nothing."""
    given = np.array([value])
    return bool(says_armed(settings, given)[0]) if says_something(settings, given)[0] else None


def is_within(time: Array, wanted: Spans) -> NDArray[np.bool_]:
    """Selects the instants (n,) [s] within the spans."""
    inside = np.zeros(time.size, dtype=bool)
    for low, high in wanted:
        inside |= (time >= low) & (time < high)
    return inside


@dataclass(slots=True)
class Arming:
    """Whether a vehicle is armed, message by message.

    Attributes:
        armed: None before anything says so.
        by_movement: whether that is concluded from outputs that move: what tells changes alone may have told the last
            one before anybody listened.
    """

    armed: bool | None = None
    by_movement: bool = False
    _has_spoken: bool = False

    def take(self, armed: bool) -> None:
        """Takes what a message says."""
        self.armed, self.by_movement, self._has_spoken = armed, False, True

    def moved(self, settings: Armed | None) -> None:
        """The outputs of the vehicle move."""
        if settings is not None and settings.events and not self._has_spoken:
            self.armed = self.by_movement = True

    def why_not(self, settings: Armed) -> str | None:
        """The reason why measurements are not learned from; None if they are."""
        if self.armed:
            return None
        if self.armed is None and not settings.events:
            return f"no {settings.topic} has arrived yet, which shows whether the vehicle is armed"
        return f"the vehicle is not armed (by {settings.topic}), so that nothing is learned"
