"""A recording as a value: one run's streams under their own names, and runs one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import BODY_YAW_RATE, VELOCITIES, YAW, Axis
from incsvr.signals import RUN_PAUSE_S, TORQUE, YAW_RATE


@dataclass(frozen=True, slots=True)
class Recording:
    """One run.

    Attributes:
        name: what people call it: the file's name.
        time: (n,) stamps [s], strictly increasing, not negative.
        columns: velocities, efforts and further channels under their own names, each (n,), NaN where not sampled.
        notes: what a person should know of how it came out of a log, one sentence each.
        axis: whose velocity and effort are learned from.
        places: where a column stands in the log, as a person types it behind `--column NAME=`; empty where the log has
            our own names.
        units: SI units of the channels that came with a unit.
    """

    name: str
    time: Array
    columns: Mapping[str, Array]
    notes: tuple[str, ...] = ()
    axis: Axis = YAW
    places: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def rate(self) -> Array:
        """(n,) the velocity of the axis [rad/s], [m/s]."""
        return self.columns[self.axis.rate]

    @property
    def effort(self) -> Array:
        """(n,) what the actuators apply along or about the axis [N m], [N]."""
        return self.columns[self.axis.effort]

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of the channels beside the axis's velocity and effort; another axis than yaw has no heading."""
        beside = {self.axis.rate, self.axis.effort, *((YAW.rate, YAW.effort, "heading") if self.axis != YAW else ())}
        return tuple(name for name in self.columns if name not in beside)

    @property
    def velocities(self) -> Mapping[str, Array]:
        """The body's other velocities that were recorded, each (n,) under its own name, NaN where not sampled."""
        return {name: self.columns[name] for name in VELOCITIES if name in self.columns and name != self.axis.rate}

    def streams(self) -> dict[str, Stream]:
        """The streams as a learner of the axis hears them: its velocity and effort as yaw_rate and torque, and the
        channels; beside another axis than yaw the vehicle's own yaw rate, too."""
        heard = {self.axis.rate: YAW_RATE, self.axis.effort: TORQUE, **{name: name for name in self.channels}}
        named = {YAW.rate: BODY_YAW_RATE, **heard}
        return {named[name]: stream for name, stream in self.body_streams().items() if name in named}

    def body_streams(self) -> dict[str, Stream]:
        """Each column as a stream of its own: its stamps (m,) [s] and values (m,), without the empty cells."""
        sampled = {name: ~np.isnan(values) for name, values in self.columns.items()}
        return {name: (self.time[sampled[name]], values[sampled[name]]) for name, values in self.columns.items()}

    def taken(self, rows: NDArray[np.bool_], columns: Mapping[str, Array] | None = None) -> Recording:
        """The rows (n,) that are true, of these columns or all."""
        columns = self.columns if columns is None else columns
        return replace(self, time=self.time[rows], columns={name: values[rows] for name, values in columns.items()})


def from_streams(name: str, streams: Streams) -> Recording:
    """A recording of streams with stamps of their own: name → (stamps [s], strictly increasing, values)."""
    time = np.unique(np.concatenate(list({id(stamps): stamps for stamps, _ in streams.values()}.values())))
    columns = {}
    for column, (stamps, values) in streams.items():
        columns[column] = np.full(time.size, np.nan)
        columns[column][np.searchsorted(time, stamps)] = values
    return Recording(name, time, columns)


def sequence(runs: Sequence[Recording]) -> Recording:
    """The runs one after the other as one recording, RUN_PAUSE_S apart, so that no sample reaches across two of them.

    The first keeps its time; the others are moved behind it.
    """
    times = [runs[0].time]
    for run in runs[1:]:
        times.append(run.time - run.time[0] + (float(times[-1][-1]) + RUN_PAUSE_S))
    columns = {
        name: np.concatenate([run.columns.get(name, np.full(run.time.size, np.nan)) for run in runs])
        for name in dict.fromkeys(name for run in runs for name in run.columns)
    }
    return Recording(" + ".join(run.name for run in runs), np.concatenate(times), columns, axis=runs[0].axis)
