"""What an effect may look at: the signals of all runs on one fine grid, and the thrust as seen from both sides."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects.even_table import EvenTable

Array = NDArray[np.float64]

MOSTLY_TORQUE = 0.65
"""Fraction of the torque's noise above which the rate side is the cleaner one: what turned the vehicle is in both."""

AT_MOST = 2.0
"""T_c in which the vehicle settles: a delay of two would be half a period of a loop that never does."""

JUMP = 6.0
"""Usual changes of a command beyond which it has jumped."""

FLATTEST = 1e-9
"""Slope of a drag that is hardly there [N m s]."""

SOME, FEW = 7, 1000
"""Of so many changes one tells what is usual, if that leaves no fewer: their median takes longer than all else here."""


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
        ends: (n,) the yaw rate as the weak form's differences need it [rad/s].
        damping: (n,) d(r) of the model as fitted so far [N m].
        drag: d [N m] of other rates [rad/s].
        acceleration: (n,) ṙ [rad/s²], free of the torque's noise.
        applied: (n,) thrust moment seen from the rate side, I ṙ + d(r) + …, after the stage in question [N m].
        command: (n,) moment seen from the torque side, before the stage in question [N m].
        expected: (n,) the command without its noise, as far as that can be told [N m].
        predicted_torque: (n,) likewise, free of what the torque's noise brings anew in a block [N m].
        uncertainty: deviation of the error of `expected` [N m].
        residual: (n,) what the model so far leaves of the torque, held over each block [N m].
        torque_noise_fraction: part of the noise that sits in the recorded torque, 0…1; the rest turned the vehicle.
        gyro: part of the equation's noise that is neither but the gyro's, 0…1.
        known: whether `command` is free of the torque's noise.
        edges: (2, n) yaw rate at the beginning of each cell and, as it is predicted from there, at its end [rad/s];
            then the torque is a command that holds through each cell. Empty where the samples are means over cells
            whose neighbours may be looked at.
        quantum: step in which the torque was recorded, 0 for none [N m].
        inertia: I₀, the declared moment of inertia [kg m²].
        scale: T_c, the time in which the yaw rate forgets itself [s].
        block: T_b [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
        rate_name: what the recordings call the velocity that is traced: `yaw_rate` here stands for any axis's.
    """

    step: float
    start: NDArray[np.intp]
    time: Array
    rate: Array
    torque: Array
    channels: Mapping[str, Array] = field(default_factory=dict)
    heading: Array = field(default_factory=_empty)
    ends: Array = field(default_factory=_empty)
    damping: Array = field(default_factory=_empty)
    drag: EvenTable = field(default_factory=lambda: EvenTable(0.0, 1.0, np.zeros(2)))
    acceleration: Array = field(default_factory=_empty)
    applied: Array = field(default_factory=_empty)
    command: Array = field(default_factory=_empty)
    expected: Array = field(default_factory=_empty)
    predicted_torque: Array = field(default_factory=_empty)
    uncertainty: float = 0.0
    residual: Array = field(default_factory=_empty)
    torque_noise_fraction: float = 0.0
    gyro: float = 0.0
    known: bool = False
    edges: Array = field(default_factory=_empty)
    quantum: float = 0.0
    inertia: float = 1.0
    scale: float = 1.0
    block: float = 1.0
    origin: tuple[float, float] = (0.0, 1.0)
    rate_name: str = "yaw_rate"

    @property
    def from_rate(self) -> bool:
        """Whether thrust effects are to be built from the rate side: most of the noise sits in the recorded torque."""
        return self.torque_noise_fraction > MOSTLY_TORQUE and not self.known

    @property
    def thrust(self) -> Array:
        """(n,) the thrust moment from the side that thrust effects are built from [N m]."""
        return self.applied if self.from_rate else self.command

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
    def turning(self) -> float:
        """Part of the noise that turned the vehicle, 0…1; the gyro's, a difference, has none of the slow part."""
        return 1.0 - self.torque_noise_fraction

    @property
    def settling(self) -> float:
        """The time in which the vehicle follows its thrust [s]: T_c, or, where a loop that never settles turns it
        faster than it settles by itself, what inertia and drag say, I σ(r)/σ(d), at most twice as long."""
        drag = float(np.std(self.damping)) if self.damping.size else 0.0
        own = self.inertia * float(np.std(self.rate)) / drag if drag > 0.0 else 0.0
        return min(max(own, self.scale), AT_MOST * self.scale)

    def __len__(self) -> int:
        return self.time.size

    def drag_at(self, rate: Array) -> Array:
        """d of other rates than the measured one [N m]."""
        return self.drag(rate)

    def drag_slope(self, usual: float) -> float:
        """Mean slope of d between ± a usual rate [N m s]; positive, as drag is."""
        low, high = self.drag(np.array([-usual, usual]))
        return max(float(high - low) / (2.0 * usual), FLATTEST)

    def runs(self) -> list[slice]:
        return [slice(int(a), int(b)) for a, b in zip(self.start[:-1], self.start[1:], strict=True)]

    def pieces(self, slices: Sequence[slice]) -> Signals:
        """These pieces of the grid as runs of their own."""
        index = np.concatenate([np.arange(piece.start, piece.stop) for piece in slices])
        start = np.concatenate([[0], np.cumsum([piece.stop - piece.start for piece in slices])]).astype(np.intp)
        cut = {
            f.name: getattr(self, f.name)[index]
            for f in fields(self)
            if f.name != "start" and isinstance(getattr(self, f.name), np.ndarray) and getattr(self, f.name).size
        }
        return replace(self, start=start, channels={k: v[index] for k, v in self.channels.items()}, **cut)

    def midpoints(self, values: Array) -> tuple[Array, Array]:
        """(n,) each: half way to the sample before and to the one after; at the ends of a run the sample itself. Where
        the rate at a cell's edges is known, that."""
        if self.edges.size:
            return self.edges[0], self.edges[1]
        between = 0.5 * (values[1:] + values[:-1])
        before, after = np.concatenate([values[:1], between]), np.concatenate([between, values[-1:]])
        first, last = self.start[:-1], self.start[1:] - 1
        before[first], after[last] = values[first], values[last]
        return before, after

    def over_jumps(self, values: Array, act: Callable[[Array], Array]) -> Array:
        """(n,) act(values); a sample that holds a jump is the mean over its two sides, not what `act` makes of theirs.

        The samples are means over cells, and a command that jumps within one has neither of its values there.
        """
        found = act(values)
        if self.edges.size:
            return found
        before, after = values[:-2], values[2:]
        change = np.abs(after - before)
        some = change[::SOME] if change.size > SOME * FEW else change
        usual = 1.4826 * float(np.partition(some, some.size // 2)[some.size // 2])
        jump = np.flatnonzero(change > JUMP * usual + 1e-12 * float(np.max(np.abs(values))))
        if not jump.size:
            return found
        jump = jump[~np.isin(jump + 1, [self.start[1:-1] - 1, self.start[1:-1]])]  # not from one run to the next
        part = (values[jump + 1] - before[jump]) / (after[jump] - before[jump])
        inside = (part > 0.0) & (part < 1.0)
        jump, part = jump[inside], part[inside]
        found[jump + 1] = (1.0 - part) * found[jump] + part * found[jump + 2]
        return found

    def integral(self, values: Array) -> Array:
        """Cumulative trapezoid of `values` over time, from zero at the start of each run."""
        out = np.zeros_like(values)
        for run in self.runs():
            x = values[run]
            np.cumsum(0.5 * self.step * (x[1:] + x[:-1]), out=out[run][1:])
        return out

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

    def slope(self, values: Array) -> Array:
        """d(values)/dt by central differences within each run."""
        out = np.empty_like(values)
        for run in self.runs():
            out[run] = np.gradient(values[run], self.step)
        return out
