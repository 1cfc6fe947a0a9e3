"""The complete samples among given instants, from what is held of the streams around them (Section IV-A)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, Streams
from incsvr.plant import damping_moment
from incsvr.signals import raw
from incsvr.signals.holding import held_command, stepped_command
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, REQUIRED, TORQUE, WIDENING_FACTOR, YAW_RATE, SignalSettings
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS, Smoothed, smooth
from incsvr.signals.streams import JUMP_S
from incsvr.signals.torque_takers import TakesTorque, TorqueSplit

LeftOut = Mapping[str, Array]
"""Each stream's name → the stamps [s] of its values that are spikes (spikes.py)."""


def samples_at(
    at: Array,
    widening: NDArray[np.int64],
    holds: NDArray[np.bool_],
    streams: Streams,
    settings: SignalSettings,
    takes: TakesTorque | None,
) -> tuple[Samples, LeftOut]:
    """The complete samples among the instants `at` (m,) [s], and the stamps of what was left out before the filter.

    Args:
        widening: (m,) by how many steps of WIDENING_FACTOR the filter is widened at each.
        holds: (m,) whether the torque is a command that was logged while it held.
        streams: whatever the filter reaches at them.
        takes: what they are freed of; None where there is nothing.
    """
    kinds = sorted(set(zip(holds.tolist(), widening.tolist(), strict=True)))
    if len(kinds) == 1:
        return _alike(at, kinds[0][1], kinds[0][0], streams, settings, takes)
    found = [
        _alike(at[(holds == holding) & (widening == step)], step, holding, streams, settings, takes)
        for holding, step in kinds
    ]
    samples = Samples.concatenate([part for part, _ in found])
    left_out = {name: np.unique(np.concatenate([each[name] for _, each in found])) for name in found[0][1]}
    return samples.take(np.argsort(samples.time)), left_out


def _alike(
    at: Array,
    widening: int,
    holds: bool,
    streams: Streams,
    settings: SignalSettings,
    takes: TakesTorque | None,
) -> tuple[Samples, LeftOut]:
    """The complete samples among instants with a filter of one width and a torque of one kind."""
    smoothing = float(settings.smoothing * WIDENING_FACTOR**widening)
    gap = settings.bridged(smoothing)
    if holds:
        torque = held_command(*streams[TORQUE], at, HALF_WINDOW_WIDTHS * smoothing, gap)
    elif settings.torque == COMMANDED and (takes is None or not takes.on_a_line):
        torque = stepped_command(*streams[TORQUE], at, smoothing, gap)
    else:
        torque = smooth(*streams[TORQUE], at, smoothing=smoothing, gap=gap)
    yaw_rate = smooth(*streams[YAW_RATE], at, smoothing=smoothing, gap=gap)
    left_out = {YAW_RATE: yaw_rate.left_out, TORQUE: torque.left_out}
    if takes is None:
        split = TorqueSplit(torque, damping_moment(torque.value, yaw_rate.slope, settings.inertia), {})
    else:
        split = takes.split(at, streams, torque, yaw_rate, smoothing, gap)
    torque, damping, parts = split.torque, split.damping, split.parts
    complete = np.flatnonzero(torque.complete & yaw_rate.complete & np.isfinite(damping))
    if complete.size < at.size:
        at, damping, parts = at[complete], damping[complete], {name: part[complete] for name, part in parts.items()}
        torque, yaw_rate = torque.take(complete), yaw_rate.take(complete)
    channels = {}
    for name in sorted(streams.keys() - set(REQUIRED)):
        filtered = smooth(*streams[name], at, smoothing=smoothing, gap=gap)
        left_out[name] = filtered.left_out
        channels[name] = np.where(filtered.complete, filtered.value, _last(*streams[name], at))
    return Samples(at, yaw_rate.value, damping, channels, parts, _raw(at, streams, torque, yaw_rate)), left_out


def _raw(at: Array, streams: Streams, torque: Smoothed, yaw_rate: Smoothed) -> dict[str, Array]:
    """The properties of the streams around the complete samples at `at` [s], for the checks."""
    shown = {raw.TORQUE: torque.value}
    shown |= {raw.RATE_SPREAD: yaw_rate.spread, raw.TORQUE_SLOPE: torque.slope}
    shown |= raw.around(TORQUE, torque) | raw.around(YAW_RATE, yaw_rate)
    return shown | (raw.newest(*streams[raw.HEADING], at, JUMP_S) if raw.HEADING in streams else {})


def _last(time: Array, value: Array, at: Array) -> Array:
    """A slow channel's last value at each instant, NaN where it is older than JUMP_S."""
    if time.size == 0:
        return np.full(at.size, np.nan)
    position = np.searchsorted(time, at, side="right") - 1
    age = at - time[np.maximum(position, 0)]
    return np.where((position >= 0) & (age <= JUMP_S), value[position], np.nan)
