"""A recording as a value: one run's streams under their own names, and runs one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import BODY_YAW_RATE, VELOCITIES, YAW, Axis
from incsvr.signals import RUN_PAUSE_S, TORQUE, YAW_RATE


@dataclass(frozen=True, slots=True)
class Recording:
    """One run.

    Attributes:
        name: what people call it: the file's name.
        own_streams: velocities, efforts and further channels under their own names: (m,) stamps [s], strictly
            increasing, not negative, and (m,) values, none of them NaN.
        notes: what a person should know of how it came out of a log, one sentence each.
        axis: whose velocity and effort are learned from.
        places: where a stream stands in the log, as a person types it behind `--column NAME=`; empty where the log has
            our own names.
        units: SI units of the channels that came with a unit.
    """

    name: str
    own_streams: Streams
    notes: tuple[str, ...] = ()
    axis: Axis = YAW
    places: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def rate(self) -> Array:
        """(m,) the velocity of the axis [rad/s], [m/s], at its own stamps."""
        return self.own_streams[self.axis.rate][1]

    @property
    def effort(self) -> Array:
        """(m,) what the actuators apply along or about the axis [N m], [N], at its own stamps."""
        return self.own_streams[self.axis.effort][1]

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of the channels beside the axis's velocity and effort; another axis than yaw has no heading."""
        beside = {self.axis.rate, self.axis.effort, *((YAW.rate, YAW.effort, "heading") if self.axis != YAW else ())}
        return tuple(name for name in self.own_streams if name not in beside)

    @property
    def velocities(self) -> Streams:
        """The body's other velocities that were recorded, under their own names."""
        own = self.own_streams
        return {name: own[name] for name in VELOCITIES if name in own and name != self.axis.rate}

    def streams(self) -> dict[str, Stream]:
        """The streams as a learner of the axis hears them: its velocity and effort as yaw_rate and torque, and the
        channels; beside another axis than yaw the vehicle's own yaw rate, too."""
        heard = {self.axis.rate: YAW_RATE, self.axis.effort: TORQUE, **{name: name for name in self.channels}}
        named = {YAW.rate: BODY_YAW_RATE, **heard}
        return {named[name]: stream for name, stream in self.own_streams.items() if name in named}

    @property
    def span(self) -> tuple[float, float]:
        """The first and the last stamp of all streams [s]."""
        return ends_of(self.own_streams)

    @property
    def time(self) -> Array:
        """(n,) the stamps of all streams together [s]: the rows of a table."""
        apart = list[Array]()
        for time, _ in self.own_streams.values():
            if not any(time is each or np.array_equal(time, each) for each in apart):
                apart.append(time)
        return apart[0] if len(apart) == 1 else np.unique(np.concatenate(apart))

    @property
    def columns(self) -> dict[str, Array]:
        """The streams as columns of a table, each (n,) in the rows of `time`, NaN where not sampled."""
        time, found = self.time, dict[str, Array]()
        for name, (stamps, values) in self.own_streams.items():
            found[name] = np.full(time.size, np.nan)
            found[name][np.searchsorted(time, stamps)] = values
        return found


def from_table(name: str, time: Array, columns: Mapping[str, Array]) -> Recording:
    """A recording of columns, each (n,), in rows at these times (n,) [s]; NaN where a column was not sampled."""
    streams = {}
    for column, values in columns.items():
        sampled = ~np.isnan(values)
        streams[column] = time[sampled], values[sampled]
    return Recording(name, streams)


def ends_of(streams: Streams) -> tuple[float, float]:
    """The first and the last stamp of streams, of which one holds a value [s]."""
    stamps = [time for time, _ in streams.values() if time.size]
    return min(float(time[0]) for time in stamps), max(float(time[-1]) for time in stamps)


def sequence(runs: Sequence[Recording]) -> Recording:
    """The runs one after the other as one recording, RUN_PAUSE_S apart, so that no sample reaches across two of them.

    The first keeps its time; the others are moved behind it.
    """
    moved, end = [runs[0].own_streams], runs[0].span[1]
    for run in runs[1:]:
        begin, start = run.span[0], end + RUN_PAUSE_S
        moved.append({name: (time - begin + start, values) for name, (time, values) in run.own_streams.items()})
        end = ends_of(moved[-1])[1]
    streams = {}
    for name in dict.fromkeys(name for each in moved for name in each):
        parts = [each[name] for each in moved if name in each]
        streams[name] = (np.concatenate([time for time, _ in parts]), np.concatenate([values for _, values in parts]))
    return Recording(" + ".join(run.name for run in runs), streams, axis=runs[0].axis)
