"""The torque ledger: at every sample what each part takes of the torque, so that damping is what the effects leave.

Effects such as a rotor's lag are faster than the samples. They are worked out on a fine grid of the vehicle's time, and
then smoothed with the very weights of torque and yaw rate (`incsvr.signals.smoothing`): the parts add up to the torque.

The grid comes in blocks, each worked out from a margin before it on, from the stamps and values there alone: how the
messages come, and where a learner is stopped, make no difference.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor, inf
from typing import Any

import numpy as np

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, INERTIA, Compensation
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant import damping_moment
from incsvr.plant.body import DECLARED_INERTIA
from incsvr.signals import SignalSettings
from incsvr.signals.coupled import BodyTorque, without
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS, Smoothed, smooth
from incsvr.signals.torque_takers import TorqueSplit

STEPS_PER_WIDTH = 6
"""Fine steps in the smoothing's standard deviation."""


class TorqueLedger:
    """Works out the effects around samples; of the past it keeps whole turns of the heading alone.

    Where the axis is one of a `body`, what the rest of it takes is taken first.
    """

    on_a_line = True

    def __init__(self, compensation: Compensation, settings: SignalSettings, body: BodyTorque | None = None) -> None:
        self._compensation, self._settings, self._body = compensation, settings, body
        self._step = settings.smoothing / STEPS_PER_WIDTH
        self._margin = ceil(compensation.margin / self._step)
        self._count = max(ceil(2.0 * settings.widest_reach / self._step), self._margin, 1)
        self._turns: tuple[float, int] | None = None
        self.needed = -inf
        """Stamps from here on are still needed [s]."""

    @property
    def ahead(self) -> float:
        """The time by which the torque must be ahead of the yaw rate [s]."""
        return max(-self._compensation.delay, 0.0)

    def advance(self, streams: Streams, until: float) -> None:
        """Takes the time [s] before which all streams are settled."""
        settings = self._settings
        earliest = until - settings.sample_period - 2.0 * settings.widest_reach
        begin = floor(earliest / (self._step * self._count)) * self._count - self._margin
        needed = begin * self._step - 2.0 * settings.longest_pause - max(self._compensation.delay, 0.0)
        if self._compensation.reads_turns:
            time, turns = self._counted(streams[HEADING_CHANNEL])
            at = int(np.searchsorted(time, needed))
            if at < time.size:
                self._turns = float(time[at]), int(turns[at])
        self.needed = needed

    def anew(self) -> TorqueLedger:
        """A ledger of the same effects that has seen nothing: the clocks began anew."""
        return TorqueLedger(self._compensation, self._settings, self._body)

    def split(
        self, at: Array, streams: Streams, torque: Smoothed, yaw_rate: Smoothed, smoothing: float, gap: float
    ) -> TorqueSplit:
        """The torque of every effect, smoothed like the torque, for `TakesTorque.split`."""
        settings, model = self._settings, self._compensation.model
        others = {} if self._body is None else self._body.parts(at, streams, smoothing, gap)
        torque = without(torque, others) if others else torque
        left = damping_moment(torque.value, yaw_rate.slope, settings.inertia)
        parts = {DECLARED_INERTIA: settings.inertia * yaw_rate.slope}
        time, grid = self._around(at, streams, HALF_WINDOW_WIDTHS * smoothing)
        for name, values in grid.items():
            known = ~np.isnan(values)
            if name == INERTIA:
                parts[name] = (model.whole_inertia - model.inertia) * yaw_rate.slope
            else:
                parts[name] = smooth(time[known], values[known], at, smoothing=smoothing, gap=gap).value
            left = left - parts[name]
        return TorqueSplit(torque, left, parts | others)

    def to_dict(self) -> dict[str, Any]:
        """The whole state as plain data; `restore` goes on from it."""
        return {"turns": self._turns}

    def restore(self, data: Mapping[str, Any]) -> None:
        """Takes up what `to_dict` of a ledger of the same effects gave."""
        turns = data["turns"]
        self._turns = None if turns is None else (float(turns[0]), int(turns[1]))

    def _around(self, at: Array, streams: Streams, reach: float) -> tuple[Array, dict[str, Array]]:
        """The blocks of the grid within reach of the instants, and the torque of each effect there."""
        if self._compensation.reads_turns:
            heading, turns = streams[HEADING_CHANNEL], self._counted(streams[HEADING_CHANNEL])[1]
            streams = {**streams, HEADING_CHANNEL: (heading[0], heading[1] + 2.0 * np.pi * turns)}
        length = self._step * self._count
        blocks = np.unique(np.floor((at[:, None] + [-reach, 0.0, reach]) / length))
        times, found = list[Array](), list[dict[str, Array]]()
        for block in blocks.tolist():
            index = np.arange(block * self._count - self._margin, (block + 1) * self._count)
            parts = self._compensation.parts(streams, index * self._step, self._settings.longest_pause)
            times.append(index[self._margin :] * self._step)
            found.append({name: values[self._margin :] for name, values in parts.items()})
        return np.concatenate(times), {name: np.concatenate([each[name] for each in found]) for name in found[0]}

    def _counted(self, heading: Stream) -> Stream:
        """(n,) stamps of a heading [s], and by how many whole turns it is more than its values."""
        time, value = heading
        turns = -np.cumsum(np.rint(np.diff(value, prepend=value[:1]) / (2.0 * np.pi)))
        if self._turns is not None and time.size:
            since, counted = self._turns
            turns = turns + (counted - turns[min(int(np.searchsorted(time, since)), time.size - 1)])
        return time, turns
