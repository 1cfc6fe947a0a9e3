"""The signals that an effect may read: all runs on one grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects.even_table import EvenTable
from incsvr.numerics import Array
from incsvr.plant.axes import of_rate
from incsvr.plant.words import AxisWords, words_of

MAX_SETTLING_SCALES = 2.0
"""Longest settling time in time scales of the motion: a delay of two would be half a period of a loop that never
does."""

MIN_SLOPE = 1e-9
"""Slope of a drag that is hardly there [N m s]."""


def _empty() -> Array:
    return np.empty(0)


@dataclass(frozen=True, slots=True)
class Signals:
    """All runs, one after the other, on a uniform grid.

    Attributes:
        step: of the grid [s].
        start: (runs + 1,) index at which each run begins, and the end.
        time: (n,) the recording's own stamps [s].
        rate: (n,) yaw rate [rad/s].
        torque: (n,) commanded yaw moment, as recorded [N m].
        channels: further streams, (n,) each.
        heading: (n,) unwrapped [rad]; the integral of the yaw rate where no heading was recorded.
        damping: (n,) d(r) [N m].
        drag: d [N m] of other rates [rad/s].
        acceleration: (n,) ṙ [rad/s²].
        applied: (n,) thrust moment behind all thrust effects [N m].
        residual: (n,) what the model so far lacks of the torque [N m].
        inertia: I₀, the declared moment of inertia [kg m²].
        scale: T_c, the time in which the yaw rate forgets itself [s].
        block: time within which a step of thrust or damping is smoothed, so that the search over its instant is [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
        torque_noise: deviation of a measured torque's own white noise [N m]; 0 for a command.
        rate_name: what the recordings call the velocity that is traced: `yaw_rate` here stands for any axis's.
    """

    step: float
    start: NDArray[np.intp]
    time: Array
    rate: Array
    torque: Array
    channels: Mapping[str, Array] = field(default_factory=dict)
    heading: Array = field(default_factory=_empty)
    damping: Array = field(default_factory=_empty)
    drag: EvenTable = field(default_factory=lambda: EvenTable(0.0, 1.0, np.zeros(2)))
    acceleration: Array = field(default_factory=_empty)
    applied: Array = field(default_factory=_empty)
    residual: Array = field(default_factory=_empty)
    inertia: float = 1.0
    scale: float = 1.0
    block: float = 1.0
    origin: tuple[float, float] = (0.0, 1.0)
    torque_noise: float = 0.0
    rate_name: str = "yaw_rate"

    @property
    def words(self) -> AxisWords:
        """The words for the quantities of the traced axis."""
        return words_of(of_rate(self.rate_name))

    @property
    def one_clock(self) -> bool:
        """Whether the recordings follow one another. Where their stamps overlap each has a clock of its own, and what
        begins or drifts at some time of it means nothing in the others."""
        return bool((np.diff(self.time) > 0.0).all())

    @property
    def progress(self) -> Array:
        """(n,) from 0 to 1 over the fitted recordings."""
        begin, end = self.origin
        progress: Array = (self.time - begin) / (end - begin)
        return progress

    @property
    def settling(self) -> float:
        """The time in which the vehicle follows its thrust [s]: T_c, or, where a loop that never settles turns it
        faster than it settles by itself, what inertia and drag say, I σ(r)/σ(d), at most twice as long."""
        drag = float(np.std(self.damping)) if self.damping.size else 0.0
        own = self.inertia * float(np.std(self.rate)) / drag if drag > 0.0 else 0.0
        return min(max(own, self.scale), MAX_SETTLING_SCALES * self.scale)

    def __len__(self) -> int:
        return self.time.size

    def drag_at(self, rate: Array) -> Array:
        """d of other rates than the measured one [N m]."""
        return self.drag(rate)

    def drag_slope(self, usual: float) -> float:
        """Mean slope of d between ± a usual rate [N m s]; positive, as drag is."""
        low, high = self.drag(np.array([-usual, usual]))
        return max(float(high - low) / (2.0 * usual), MIN_SLOPE)

    def runs(self) -> list[slice]:
        """Each run as a slice of the grid."""
        return [slice(int(a), int(b)) for a, b in zip(self.start[:-1], self.start[1:], strict=True)]

    def pieces(self, slices: Sequence[slice]) -> Signals:
        """The signals of these pieces of the grid, as runs of their own."""
        index = np.concatenate([np.arange(piece.start, piece.stop) for piece in slices])
        start = np.concatenate([[0], np.cumsum([piece.stop - piece.start for piece in slices])]).astype(np.intp)
        cut = {
            f.name: getattr(self, f.name)[index]
            for f in fields(self)
            if f.name != "start" and isinstance(getattr(self, f.name), np.ndarray) and getattr(self, f.name).size
        }
        return replace(self, start=start, channels={k: v[index] for k, v in self.channels.items()}, **cut)

    def lowpass(self, values: Array, time_constant: float) -> Array:
        """First-order lag: T x' = values − x (trapezoid rule), settled at the start of each run."""
        out = np.empty_like(values)
        half = 0.5 * self.step / time_constant
        gain, pole = half / (1.0 + half), (1.0 - half) / (1.0 + half)
        for run in self.runs():
            x = values[run]
            out[run], _ = lfilter([gain, gain], [1.0, -pole], x, zi=np.array([(1.0 - gain) * x[0]]))
        return out

    def later(self, values: Array, delay: float) -> Array:
        """values(t + delay), held at the ends of each run; a negative delay looks back."""
        out = np.empty_like(values)
        steps, part = divmod(delay / self.step, 1.0)
        for run in self.runs():
            x = values[run]
            moved = x.take(np.arange(int(steps), int(steps) + x.size + 1), mode="clip")
            out[run] = (1.0 - part) * moved[:-1] + part * moved[1:]
        return out
