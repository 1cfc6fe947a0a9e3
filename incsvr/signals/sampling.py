"""The complete samples among given instants, from what is held of the streams around them (Section IV-A)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from incsvr.plant import damping_moment
from incsvr.samples import Array, Samples
from incsvr.signals import raw
from incsvr.signals.settings import REQUIRED, TORQUE, WIDER, YAW_RATE, SignalSettings
from incsvr.signals.smoothing import Smoothed, smooth
from incsvr.signals.streams import JUMP

if TYPE_CHECKING:
    from incsvr.torque_ledger import TorqueLedger

Held = Mapping[str, tuple[Array, Array]]
"""Each stream's name → its stamps [s] and values."""


def samples_at(
    at: Array, widening: NDArray[np.int64], held: Held, settings: SignalSettings, ledger: TorqueLedger | None
) -> Samples:
    """The complete samples among the instants `at` (m,) [s].

    Args:
        widening: (m,) by how many steps of WIDER the filter is widened at each.
        held: whatever the filter reaches at them.
        ledger: what the traced effects take of the torque; None where there are none.
    """
    steps = sorted(set(widening.tolist()))
    if len(steps) == 1:
        return _alike(at, steps[0], held, settings, ledger)
    parts = [_alike(at[widening == step], step, held, settings, ledger) for step in steps]
    samples = Samples.concatenate(parts)
    return samples.take(np.argsort(samples.time))


def _alike(at: Array, widening: int, held: Held, settings: SignalSettings, ledger: TorqueLedger | None) -> Samples:
    """The complete samples among instants with a filter of one width."""
    smoothing = float(settings.smoothing * WIDER**widening)
    gap = settings.bridged(smoothing)
    torque = smooth(*held[TORQUE], at, smoothing=smoothing, gap=gap)
    yaw_rate = smooth(*held[YAW_RATE], at, smoothing=smoothing, gap=gap)
    damping, parts = damping_moment(torque.value, yaw_rate.slope, settings.inertia), dict[str, Array]()
    if ledger is not None:
        damping, parts = ledger.split(at, torque, yaw_rate, smoothing, gap)
    complete = np.flatnonzero(torque.complete & yaw_rate.complete & np.isfinite(damping))
    if complete.size < at.size:
        at, damping, parts = at[complete], damping[complete], {name: part[complete] for name, part in parts.items()}
        torque, yaw_rate = torque.take(complete), yaw_rate.take(complete)
    channels = {}
    for name in sorted(held.keys() - set(REQUIRED)):
        filtered = smooth(*held[name], at, smoothing=smoothing, gap=gap)
        channels[name] = np.where(filtered.complete, filtered.value, _last(*held[name], at))
    return Samples(
        at,
        yaw_rate.value,
        damping,
        channels,
        parts,
        _raw(at, held, torque, yaw_rate),
    )


def _raw(at: Array, held: Held, torque: Smoothed, yaw_rate: Smoothed) -> dict[str, Array]:
    """What the streams show around the complete samples at `at` [s], for the checks."""
    shown = {raw.TORQUE: torque.value}
    shown |= raw.around(TORQUE, torque) | raw.around(YAW_RATE, yaw_rate)
    return shown | (raw.newest(*held[raw.HEADING], at, JUMP) if raw.HEADING in held else {})


def _last(time: Array, value: Array, at: Array) -> Array:
    """A slow channel's last value at each instant, NaN where it is older than JUMP."""
    if time.size == 0:
        return np.full(at.size, np.nan)
    position = np.searchsorted(time, at, side="right") - 1
    age = at - time[np.maximum(position, 0)]
    return np.where((position >= 0) & (age <= JUMP), value[position], np.nan)
