"""The constants of a vehicle for the checks, and their memory between two batches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals.samples import Samples

PRIOR_LAG_PRECISION = 1.0 / 0.25**2
"""Precision [s⁻²] with which the streams are taken to be together before anything is learned: rotors trail by some
tenths."""
RATE_BINS = 40
"""Bins of the range of yaw rates in which learned samples are counted: narrower than any kernel that spans it."""
MIN_BIN_SAMPLES = 5
"""Samples learned in a bin and the two beside it from which on the curve is judged by there: a kernel that bridges what
was only passed through errs by far more than it doubts itself."""


@dataclass(frozen=True, slots=True)
class Vehicle:
    """The constants of a vehicle for the checks.

    Attributes:
        inertia: as declared [kg m²].
        rate_range: the lowest and highest yaw rate [rad/s].
        smoothing: standard deviation of the filter [s].
        sign_known: somebody knows that torque and yaw rate count in the same direction, whatever the motion says.
        words: what findings call the quantities of the axis.
    """

    inertia: float
    rate_range: tuple[float, float]
    smoothing: float
    sign_known: bool = False
    words: AxisWords = YAW_WORDS

    @property
    def largest_rate(self) -> float:
        return max(abs(rate) for rate in self.rate_range)


@dataclass(frozen=True, slots=True)
class State:
    """The memory between two batches; at most a batch.

    Attributes:
        paused_since: the time [s] of the first sample that was put aside; None where learning goes on.
        paused_by: the checks that paused it.
        kinds: the kinds of what they found.
        learned: batches of turning that were learned, as far as they count.
        usual: how far each stream scatters within a window, in its unit.
        reach: how far each stream goes within a batch, in its unit.
        periods: between two stamps of each stream [s].
        lag, precision: how much later than the yaw rate the torque usually comes [s], and how sure that is [s⁻²].
        before: the last batch, to be looked at together with the next; None where it is not to be.
        agreeing: batches put aside, one after the other, that fit each other and not what is learned.
        told: when the last change was told [s].
        drift: by how much the torque's stamps should have run ahead of the yaw rate's, by their pace [s].
        rates: (RATE_BINS,) learned samples of turning in each part of the range of yaw rates.
    """

    paused_since: float | None = None
    paused_by: frozenset[str] = frozenset()
    kinds: frozenset[str] = frozenset()
    learned: int = 0
    usual: Mapping[str, float] = field(default_factory=dict)
    reach: Mapping[str, float] = field(default_factory=dict)
    periods: Mapping[str, float] = field(default_factory=dict)
    lag: float = 0.0
    precision: float = PRIOR_LAG_PRECISION
    before: Samples | None = None
    agreeing: int = 0
    told: float | None = None
    drift: float = 0.0
    rates: tuple[int, ...] = (0,) * RATE_BINS

    def near(self, vehicle: Vehicle, rate: Array) -> NDArray[np.bool_]:
        """(n,) whether enough was learned near each yaw rate (n,) [rad/s]."""
        counted = np.convolve(self.rates, np.ones(3), mode="same")
        return np.asarray(counted[_bins(vehicle, rate)] >= MIN_BIN_SAMPLES)

    def counted(self, vehicle: Vehicle, rate: Array) -> tuple[int, ...]:
        """`rates` with learned ones (n,) [rad/s]."""
        return tuple((np.array(self.rates) + np.bincount(_bins(vehicle, rate), minlength=RATE_BINS)).tolist())


def _bins(vehicle: Vehicle, rate: Array) -> NDArray[np.int64]:
    """(n,) the bin of each rate; what is beyond the range falls into its last ones."""
    low, high = vehicle.rate_range
    return np.clip((RATE_BINS * (rate - low) / (high - low)).astype(np.int64), 0, RATE_BINS - 1)
