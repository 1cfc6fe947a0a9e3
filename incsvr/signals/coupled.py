"""The torque of a body's other velocities and attitude on an axis; each is a stream with a clock of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams
from incsvr.plant import damping_moment
from incsvr.plant.axes import stream_of
from incsvr.plant.body import CORIOLIS, COUPLED_INERTIA, DECLARED_INERTIA, RESTORING, Coupled
from incsvr.signals.settings import TORQUE, YAW_RATE
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS, Smoothed, smooth
from incsvr.signals.torque_takers import TakesTorque, TorqueSplit

MAX_PAUSE_S = 1.0
"""Longest pause between two values of another velocity, or of an angle, across which it is known [s]: a Doppler log
gives one to ten a second, and a hull's speed hardly changes within one."""


class BodyTorque:
    """The torque of the rest of a body on an axis, computed from the streams at each sample."""

    on_a_line = False
    needed, ahead = inf, 0.0

    def __init__(self, coupled: Coupled, inertia: float) -> None:
        self._coupled, self._inertia = coupled, inertia

    def advance(self, streams: Streams, until: float) -> None:
        """Needs nothing beforehand."""

    def parts(self, at: Array, streams: Streams, smoothing: float, gap: float) -> dict[str, Array]:
        """The parts by `body_parts`, for its own body."""
        return body_parts(self._coupled, at, streams, smoothing, gap)

    def split(
        self, at: Array, streams: Streams, torque: Smoothed, yaw_rate: Smoothed, smoothing: float, gap: float
    ) -> TorqueSplit:
        """The torque of each part, for `TakesTorque.split`."""
        others = self.parts(at, streams, smoothing, gap)
        torque = without(torque, others)
        damping = damping_moment(torque.value, yaw_rate.slope, self._inertia)
        return TorqueSplit(torque, damping, {DECLARED_INERTIA: self._inertia * yaw_rate.slope} | others)

    def anew(self) -> TakesTorque:
        """Itself."""
        return self

    def to_dict(self) -> None:
        """Nothing: a body has no state."""

    def restore(self, data: Any) -> None:
        """Nothing: a body has no state."""


def without(torque: Smoothed, others: Mapping[str, Array]) -> Smoothed:
    """The torque less what others take (n,) each [N m]: what is left acts on the axis as if it were by itself."""
    return replace(torque, value=torque.value - np.sum(list(others.values()), axis=0))


def body_parts(coupled: Coupled, at: Array, streams: Streams, smoothing: float, gap: float) -> dict[str, Array]:
    """The torque of each part (m,) [N m] at the instants `at` (m,) [s], through the filter of torque and rate.

    A product is filtered, not multiplied of filtered velocities: filtering commutes with the equation of motion alone.
    All are carried to the stamps of the axis's own velocity before, so that a slow stream is no hindrance. NaN where
    one of them is not known.
    """
    time, rate = streams[YAW_RATE]
    known = _known(coupled, streams, at, HALF_WINDOW_WIDTHS * smoothing, gap)
    others = {name: _at(time, streams[stream_of(coupled.axis, name)]) for name in coupled.velocities}

    def filtered(values: Array) -> Array:
        return np.where(known, smooth(time, values, at, smoothing=smoothing, gap=gap).value, np.nan)

    found = {CORIOLIS: filtered(coupled.coriolis(rate, others))}
    rises = {
        name: np.where(known, smooth(time, others[name], at, smoothing=smoothing, gap=gap).slope, np.nan)
        for name in coupled.coupled_to
    }
    inertial = coupled.coupled_inertia(rises)
    if inertial is not None:
        found[COUPLED_INERTIA] = inertial
    restoring = coupled.restoring({name: _at(time, streams[name]) for name in coupled.angles}, time.size)
    if restoring is not None:
        found[RESTORING] = filtered(restoring)
    return found


def motion_at(
    coupled: Coupled, streams: Streams, at: Array, smoothing: float
) -> tuple[dict[str, tuple[Array, Array]], dict[str, Array]]:
    """The other velocities with their accelerations, and the angles, at the instants `at` (m,) [s], (m,) each.

    Through a filter this wide [s]; at the ends of a recording, where it has no window, as they are.
    """
    motion = {}
    for name in coupled.velocities:
        stamps, values = streams[stream_of(coupled.axis, name)]
        filtered = smooth(stamps, values, at, smoothing=smoothing, gap=2.0 * smoothing)
        raw = np.interp(at, stamps, values)
        slope, known = np.gradient(raw, at), filtered.complete
        motion[name] = np.where(known, filtered.value, raw), np.where(known, filtered.slope, slope)
    return motion, {name: _at(at, streams[name]) for name in coupled.angles}


def decoupled_streams(coupled: Coupled, streams: Streams, smoothing: float) -> tuple[Streams, dict[str, Array]]:
    """The streams with what they take taken from the torque, so that the axis moves as if by itself, and each part.

    Values of the torque at which one of them is not known are left out. The axis's own velocity enters as measured.

    Args:
        coupled: the axis in its body.
        streams: of a run, with those of the body.
        smoothing: standard deviation of the filter of the other velocities [s].

    Returns:
        the streams, and the parts (n,) each [N m] at the stamps of the torque.

    Raises:
        BadInput: the others are never known while the torque is.
    """
    time, torque = streams[TORQUE]
    known = _known(coupled, streams, time, 0.0, 2.0 * smoothing)
    if known.sum() < 2:
        raise BadInput(
            f"the streams {', '.join(coupled.streams)}, which the mass matrix needs, do not arrive with the torque, or "
            f"less often than every {MAX_PAUSE_S:g} s; record them, or leave out the mass matrix"
        )
    at = time[known]
    motion, angles = motion_at(coupled, streams, at, smoothing)
    parts = coupled.parts(_at(at, streams[YAW_RATE]), motion, angles)
    left = torque[known] - np.sum(list(parts.values()), axis=0)
    return {**streams, TORQUE: (at, left)}, parts


def _at(at: Array, stream: tuple[Array, Array]) -> Array:
    """A stream on lines between its values."""
    return np.interp(at, *stream) if stream[0].size else np.zeros_like(at)


def _known(coupled: Coupled, streams: Streams, at: Array, reach: float, gap: float) -> NDArray[np.bool_]:
    """The instants at which each stream has values from `reach` before to `reach` after, none further apart than
    MAX_PAUSE_S or `gap`, by which it may also begin later or end earlier [s]."""
    known = np.ones(at.size, dtype=bool)
    for name in coupled.streams:
        stamps = streams[name][0]
        if stamps.size < 2:
            return np.zeros(at.size, dtype=bool)
        known &= (stamps[0] - (at - reach) <= gap) & ((at + reach) - stamps[-1] <= gap)
        first = np.maximum(np.searchsorted(stamps, at - reach, side="right") - 1, 0)
        last = np.minimum(np.searchsorted(stamps, at + reach, side="left"), stamps.size - 1)
        pauses = np.concatenate(([0], np.cumsum(np.diff(stamps) > max(gap, MAX_PAUSE_S))))
        known &= pauses[first] == pauses[last]
    return known
