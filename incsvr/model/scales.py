"""The time scales of recordings and models, which the step and the windows of a fit follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model.series import duration, noise, period, values
from incsvr.model.structure import Structure, Theta
from incsvr.numerics import Array, Streams


def time_constants(structure: Structure, theta: Theta, runs: Sequence[Streams], quantile: float) -> Array:
    """(axes,) M over the slope of the damping at a quantile of the recorded speeds [s], at most a twentieth of the
    recordings."""
    found = []
    for axis in structure.axes:
        speed = float(np.quantile(np.abs(values(runs, axis)), quantile))
        slope = theta.get(f"linear@{axis}", 0.0) + 2.0 * theta.get(f"quadratic@{axis}", 0.0) * speed
        found.append(min(structure.inertia(theta, axis) / max(slope, 1e-12), duration(runs, axis) / 20.0))
    return np.array(found)


def motion_scale(runs: Sequence[Streams], name: str) -> float:
    """The lag at which the autocorrelation of a stream's motion, without its white noise, falls below a half [s]."""
    found = []
    for run in runs:
        t, v = run[name]
        even = np.interp(np.linspace(t[0], t[-1], t.size), t, v)
        even = even - even.mean()
        spectrum = np.abs(np.fft.rfft(even, 2 * even.size)) ** 2
        correlation = np.fft.irfft(spectrum)[: even.size]
        correlation[0] = max(correlation[0] - even.size * noise(v) ** 2, correlation[1])
        below = np.flatnonzero(correlation < 0.5 * correlation[0])
        found.append(float(below[0] if below.size else even.size) * (t[-1] - t[0]) / max(t.size - 1, 1))
    return float(np.median(found))


def fastest(structure: Structure, theta: Theta, runs: Sequence[Streams], samples: float = 5.0) -> float:
    """The shortest time constant that the motion shows [s]: of a model, but no shorter than some samples where the
    motion itself is slower, because noise of an effort drives the drag of a fit."""
    constants = time_constants(structure, theta, runs, 0.95)
    scales = np.array([motion_scale(runs, axis) for axis in structure.axes])
    beats = np.array([period(runs, axis) for axis in structure.axes])
    return float(np.clip(constants, np.minimum(0.2 * scales, samples * beats), scales).min())


def coarse_period(runs: Sequence[Streams], axes: Sequence[str], constant: float, share: float = 0.05) -> float:
    """The time between samples that shows a motion with this fastest time constant [s]: what is finer only repeats."""
    return max(min(period(runs, axis) for axis in axes), share * constant)


def step_of(sample: float, constant: float, fine: float = 0.05) -> float:
    """An even part of the sample period [s]: at most two fifths of the fastest time constant; the whole period where it
    is no more than a `fine` share of that.

    Else half a period at most, because a velocity bends where a command changes: coarser steps put inertias out of 17
    of 64 intervals that hold 63 with these. An eighth at least, because no log shows faster motion.
    """
    if sample <= fine * constant:
        return sample
    parts = np.ceil(sample / (0.4 * constant) - 1e-9)
    return float(sample / np.clip(2.0 * np.ceil(0.5 * parts), 2.0, 8.0))
