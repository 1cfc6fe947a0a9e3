"""Raw streams on even steps, for free runs to start from, to be driven by, and to be held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.forecasting.other_influences import BY_ITSELF, OtherInfluences
from incsvr.numerics import Array, Streams, integral_at
from incsvr.plant.body import Coupled
from incsvr.signals.known_instants import known_at

STEPS_PER_WIDTH = 2.0
"""Steps in a width of the filter: what is quicker is the gyro's noise to the learner."""
MAX_BRIDGED_STEPS = 2
"""Steps without a value that are bridged."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The means of two streams over even steps.

    Attributes:
        time: (n,) the middles of the steps [s], at whole numbers of steps.
        step: [s].
        rate, torque: (n,) means in each [rad/s], [N m]; NaN where a stream paused.
        sample_period: between two samples of the learner [s].
        beside: what moves the axis beside its torque at these times.
    """

    time: Array
    step: float
    rate: Array
    torque: Array
    sample_period: float
    beside: OtherInfluences = BY_ITSELF

    @staticmethod
    def of(
        rate: tuple[Array, Array], torque: tuple[Array, Array], smoothing: float, sample_period: float, held: bool
    ) -> Grid:
        """The streams, each (stamps [s], values), as far as both reach.

        Args:
            smoothing: width of the learner's filter [s].
            sample_period: of the learner [s].
            held: whether the torque holds until its next value; else it runs on a line between two.
        """
        step = Grid.step_for(smoothing)
        if not rate[0].size or not torque[0].size:
            nothing = np.empty(0)
            return Grid(nothing, step, nothing, nothing, sample_period)
        first = int(np.ceil(max(rate[0][0], torque[0][0]) / step + 0.5))
        last = int(np.floor(min(rate[0][-1], torque[0][-1]) / step - 0.5))
        time = step * np.arange(first, last + 1, dtype=np.float64)
        return Grid(time, step, _means(*rate, time, step, False), _means(*torque, time, step, held), sample_period)

    @staticmethod
    def step_for(smoothing: float) -> float:
        """The grid's step beside a filter of this width [s]."""
        return smoothing / STEPS_PER_WIDTH

    def part(self, kept: NDArray[np.bool_] | slice) -> Grid:
        """The steps (n,) that are kept."""
        return replace(
            self, time=self.time[kept], rate=self.rate[kept], torque=self.torque[kept], beside=self.beside.take(kept)
        )

    def among(self, streams: Streams, names: Sequence[str], body: Coupled | None, smoothing: float) -> Grid:
        """The grid with channels and a body, as `OtherInfluences.at` takes them; NaN torque where one is not known."""
        needed = (*names, *(() if body is None else body.streams))
        torque = np.where(known_at(self.time, streams, needed), self.torque, np.nan)
        return replace(self, torque=torque, beside=OtherInfluences.at(self.time, streams, names, body, smoothing))

    def stretches(self) -> list[slice]:
        """The parts in which neither stream paused."""
        whole = np.isfinite(self.rate) & np.isfinite(self.torque)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], whole.astype(np.int8), [0]))))
        return [slice(int(a), int(b)) for a, b in edges.reshape(-1, 2) if b - a > 2]


def _means(stamps: Array, values: Array, at: Array, step: float, held: bool) -> Array:
    """(n,) the mean of a stream over the step around each time, NaN where it paused for longer than it does else."""
    if not at.size:
        return np.empty(0)
    edges = np.concatenate((at - 0.5 * step, [at[-1] + 0.5 * step]))
    gaps = np.diff(stamps)
    usual = float(np.median(gaps)) if gaps.size else step
    means = np.diff(integral_at(stamps, values, edges, held)) / step
    before = np.clip(np.searchsorted(stamps, edges, side="right") - 1, 0, stamps.size - 1)
    after = np.minimum(before + 1, stamps.size - 1)
    paused = stamps[after] - stamps[before] > max(MAX_BRIDGED_STEPS * step, 3.0 * usual)
    return np.asarray(np.where(paused[1:] | paused[:-1], np.nan, means))
