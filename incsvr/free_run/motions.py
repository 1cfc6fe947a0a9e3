"""Runs as motions: the torque as input, the measured yaw rate as what a simulation must meet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from incsvr.numerics import Array, Streams
from incsvr.plant.body import Coupled
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.coupled import motion_at
from incsvr.signals.holding import MAX_HOLDING_PERIODS
from incsvr.signals.settings import SETTLING_S

MIN_MOTION_S = 1.0
"""Length of a motion [s] below which it shows nothing of a vehicle."""
MIN_HELD_MOTION_S = 0.4
"""Length [s] below which a motion while the torque holds shows nothing: there are many of those, and together they show
it."""


@dataclass(frozen=True, slots=True)
class Motion:
    """One stretch of time without a gap in either stream.

    Attributes:
        torque_time: (n,) stamps of the torque [s], strictly increasing.
        torque: (n,) [N m]; before its first stamp its first value is taken.
        rate_time: (m,) stamps of the yaw rate [s], strictly increasing, none after the torque ends.
        yaw_rate: (m,) [rad/s].
        linear: (n,) what other velocities make of the own one at the torque's stamps [N m s]; None for nothing.
    """

    torque_time: Array
    torque: Array
    rate_time: Array
    yaw_rate: Array
    linear: Array | None = None

    def among(self, coupled: Coupled, streams: Streams, smoothing: float) -> Motion:
        """The motion with what the body's other velocities and its attitude take, through a filter this wide [s]."""
        motion, angles = motion_at(coupled, streams, self.torque_time, smoothing)
        outside, linear = coupled.driving(motion, angles, self.torque_time.size)
        return replace(self, torque=self.torque - outside, linear=linear)

    def error(self, simulate: Callable[[Array, Array, float], Array]) -> Array:
        """(m,) simulated minus measured yaw rate [rad/s], started from the first measured yaw rate.

        Args:
            simulate: (stamps (k,), torque (k,), first yaw rate) → yaw rate (k,).
        """
        begin = self.rate_time[0]
        time = np.concatenate(([begin], self.torque_time[self.torque_time > begin]))
        torque = np.interp(time, self.torque_time, self.torque)
        simulated = simulate(time, torque, float(self.yaw_rate[0]))
        return np.asarray(np.interp(self.rate_time, time, simulated) - self.yaw_rate)


def motions(streams: Streams, gap: float) -> list[Motion]:
    """The stretches of a recording in which neither stream pauses for longer than `gap` [s]."""
    (rate_time, rate), (torque_time, torque) = streams[YAW_RATE], streams[TORQUE]
    found = []
    for begin, end in _stretches(rate_time, gap):
        for torque_begin, torque_end in _stretches(torque_time, gap):
            start = begin if torque_begin <= begin + gap else torque_begin
            stop = min(end, torque_end)
            rates = (rate_time >= start) & (rate_time <= stop)
            torques = (torque_time >= torque_begin) & (torque_time <= torque_end)
            if stop - start >= MIN_MOTION_S and rates.any():
                found.append(Motion(torque_time[torques], torque[torques], rate_time[rates], rate[rates]))
    return found


def held_motions(streams: Streams, gap: float) -> list[Motion]:
    """The stretches in which a command that was logged while it held stayed the same, and the rotors have followed.

    Args:
        streams: of a recording.
        gap: the longest pause of the yaw rate [s]; the torque is known as long as it repeats itself.
    """
    (rate_time, rate), (time, command) = streams[YAW_RATE], streams[TORQUE]
    edges = np.concatenate(([0], np.flatnonzero(np.diff(command) != 0.0) + 1, [time.size]))
    longest = MAX_HOLDING_PERIODS * float(np.median(np.diff(time))) if time.size > 1 else gap
    found = []
    for first, last in zip(edges[:-1], edges[1:] - 1, strict=True):
        begin, end = float(time[first]) + SETTLING_S, float(time[last])
        if end - begin < MIN_HELD_MOTION_S or float(np.diff(time[first : last + 1]).max()) > longest:
            continue
        within = (rate_time >= begin) & (rate_time <= end)
        stamps, rates = rate_time[within], rate[within]
        for start, stop in _stretches(stamps, gap):
            one = (stamps >= start) & (stamps <= stop)
            if stop - start >= MIN_HELD_MOTION_S:  # a free run stops at the stamps of the torque: at each of the rate's
                found.append(Motion(stamps[one], np.full(int(one.sum()), command[first]), stamps[one], rates[one]))
    return found


def _stretches(time: Array, gap: float) -> list[tuple[float, float]]:
    """First and last stamp of each stretch without a longer pause."""
    if time.size == 0:
        return []
    breaks = np.flatnonzero(np.diff(time) > gap)
    begins, ends = np.concatenate(([0], breaks + 1)), np.concatenate((breaks, [time.size - 1]))
    return [(float(time[first]), float(time[last])) for first, last in zip(begins, ends, strict=True)]
