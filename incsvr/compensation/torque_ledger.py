"""The torque ledger: at every sample what each part takes of the torque, so that damping is what the effects leave.

Effects such as a rotor's lag are faster than the samples. They are worked out on a fine grid of the vehicle's time, and
then smoothed with the very weights of torque and yaw rate (`incsvr.signals.smoothing`): the parts add up to the torque.

Like the samples, the parts follow from the stamps and values alone: a point of the grid is worked out once, as soon as
nothing that may still come could change it.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation, FilterState, GridSegment, plain_data
from incsvr.numerics import Array, Streams
from incsvr.plant import damping_moment
from incsvr.plant.body import DECLARED_INERTIA
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.coupled import BodyTorque, without
from incsvr.signals.smoothing import Smoothed, smooth
from incsvr.signals.streams import JUMP_S
from incsvr.signals.torque_takers import TorqueSplit

STEPS_PER_WIDTH = 6
"""Fine steps in the smoothing's standard deviation."""


class TorqueLedger:
    """Works out the effects along the streams; its memory is bounded by the streams' own.

    Where the axis is one of a `body`, what the rest of it takes is taken first.
    """

    on_a_line = True

    def __init__(self, compensation: Compensation, settings: SignalSettings, body: BodyTorque | None = None) -> None:
        self._compensation, self._settings, self._body = compensation, settings, body
        self._pairs = compensation.pairs()
        self._step = settings.smoothing / STEPS_PER_WIDTH
        self._channels = compensation.reads(settings.channels)
        self._next = 0
        self._carried = FilterState()
        self._time: Array = np.empty(0)
        self._values: list[Array] = [np.empty(0) for _ in self._pairs]

    @property
    def needed(self) -> float:
        """Stamps from here on are still needed [s]."""
        return self._next * self._step - 2.0 * self._settings.longest_pause - max(self._compensation.delay, 0.0)

    @property
    def ahead(self) -> float:
        """The time by which the torque must be ahead of the yaw rate [s]."""
        return max(-self._compensation.delay, 0.0)

    def advance(self, streams: Streams, until: float) -> None:
        """Works out the grid up to and with a time [s] before which all streams are settled."""
        end = floor(until / self._step)
        while end * self._step <= until:
            end += 1
        index = _near(streams[YAW_RATE][0], self._step, self._settings.longest_pause)
        index = index[(index >= self._next) & (index < end)]
        self._next = max(self._next, end)
        at = np.asarray(index * self._step, dtype=np.float64)
        values = {
            "rate": _linear(*streams[YAW_RATE], at, self._settings.longest_pause),
            "torque": _linear(*streams[TORQUE], at, self._settings.longest_pause),
            "delayed": _linear(*streams[TORQUE], at - self._compensation.delay, self._settings.longest_pause),
            **{name: _linear(*streams[name], at, JUMP_S, name == HEADING_CHANNEL) for name in self._channels},
        }
        good = ~np.any(np.isnan(list(values.values())), axis=0)
        if not good.any():
            return
        found = {name: each[good] for name, each in values.items()}
        rate, torque, delayed = (found.pop(name) for name in ("rate", "torque", "delayed"))
        piece = GridSegment(index[good], self._step, rate, torque, delayed, found)
        parts, self._carried = self._compensation.split(piece, self._carried)
        self._time = np.concatenate((self._time, at[good]))
        self._values = [np.concatenate(pair) for pair in zip(self._values, parts, strict=True)]

    def anew(self) -> TorqueLedger:
        """A ledger of the same effects that has seen nothing: the clocks began anew."""
        return TorqueLedger(self._compensation, self._settings, self._body)

    def split(
        self, at: Array, streams: Streams, torque: Smoothed, yaw_rate: Smoothed, smoothing: float, gap: float
    ) -> TorqueSplit:
        """The torque of every effect, smoothed like the torque, for `TakesTorque.split`."""
        settings = self._settings
        others = {} if self._body is None else self._body.parts(at, streams, smoothing, gap)
        torque = without(torque, others) if others else torque
        left = damping_moment(torque.value, yaw_rate.slope, settings.inertia)
        parts = {DECLARED_INERTIA: settings.inertia * yaw_rate.slope}
        factors: list[tuple[str, Array]] = []
        for (effect, term), values in zip(self._pairs, self._values, strict=True):
            if effect.acts == "inertia":
                part: Array = term.coefficients[0] * yaw_rate.slope
            else:
                part = smooth(self._time, values, at, smoothing=smoothing, gap=gap).value
            if effect.acts == "damping":
                factors.append((term.effect, part))
                continue
            parts[term.effect] = parts.get(term.effect, 0.0) + part
            left = left - part
        for name, factor in factors:
            damping = left / factor
            parts[name] = parts.get(name, 0.0) + left - damping
            left = damping
        return TorqueSplit(torque, left, parts | others)

    def forget(self, before: float) -> None:
        """Drops the points before this time [s]."""
        first = int(np.searchsorted(self._time, before))
        self._time, self._values = self._time[first:], [values[first:] for values in self._values]

    def to_dict(self) -> dict[str, Any]:
        """The whole state as plain data; `restore` goes on from it."""
        return {
            "next": self._next,
            "carried": plain_data(self._carried),
            "time": self._time.tolist(),
            "values": [values.tolist() for values in self._values],
        }

    def restore(self, data: Mapping[str, Any]) -> None:
        """Takes up what `to_dict` of a ledger of the same effects gave."""
        self._next = int(data["next"])
        self._carried = FilterState(**data["carried"])
        self._time = np.array(data["time"], dtype=np.float64)
        self._values = [np.array(values, dtype=np.float64) for values in data["values"]]


def _near(time: Array, step: float, gap: float) -> NDArray[np.int64]:
    """The numbers of all grid points between two stamps at most `gap` apart, and some beside; pauses cost nothing."""
    whole = np.flatnonzero(np.diff(time) <= gap)
    first = np.floor(time[whole] / step).astype(np.int64)
    counts = np.floor(time[whole + 1] / step).astype(np.int64) + 2 - first
    return np.unique(np.repeat(first - (np.cumsum(counts) - counts), counts) + np.arange(counts.sum()))


def _linear(time: Array, value: Array, at: Array, gap: float, turning: bool = False) -> Array:
    """A stream at (n,) instants, linear between two stamps at most `gap` apart, else NaN; `turning` for an angle.

    Each value follows from its two neighbours alone, to the last bit.
    """
    if time.size < 2:
        return np.full(at.size, np.nan)
    after = np.searchsorted(time, at, side="left")
    inside = (after > 0) & (after < time.size)
    after = np.clip(after, 1, time.size - 1)
    width, rise = time[after] - time[after - 1], value[after] - value[after - 1]
    if turning:
        rise = rise - 2.0 * np.pi * np.rint(rise / (2.0 * np.pi))
    found = value[after - 1] + (at - time[after - 1]) / width * rise
    return np.where(inside & (width <= gap), found, np.nan)
