"""The residual of a batch by the learned curve, and the single cause that explains it best.

Of e = d − f(r) each cause makes a shape of its own:

    the damping changed         e ∝ f(r)       a vehicle may do that: it is told, and learned
    the thrust changed          e ∝ τ          the same
    a constant moment           e ∝ 1          the same
    one side changed            e ∝ |f(r)|     the same
    the gyro's zero moved       e ∝ −f'(r)     no vehicle shifts its curve along the yaw rate: a sensor does
    the streams are apart       e = τ(t) − τ(t + δ)    so do the clocks
    nothing of this             and e is large: torque and yaw rate do not belong together
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.checks.curve import Curve
from incsvr.numerics import Array, robust_deviation
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

VEHICLE_CAUSES = ("gain", "thrust", "moment", "one side")
"""Causes of a misfit that are a change of the vehicle."""
SENSOR_CAUSES = ("zero", "lag")
"""Causes that are a fault of a sensor."""
TRIMMED_DEVIATIONS = 3.5
"""Robust deviations beyond which a sample has no part in an estimate."""
CURVE_ERROR_NOISES = 0.3
"""Error of the learned curve itself in noise levels, at least, in a shape that may be any cause's."""
DELAY_STEP_S = 0.125
"""Step between two delays of the torque that are tried [s]."""
DELAYS_S: Array = DELAY_STEP_S * np.arange(-32.0, 33.0, dtype=np.float64)
"""Delays that are tried beside the usual one [s]: beyond, torque and yaw rate do not belong together at all."""
AGREEING_NOISES = 1.5
"""Noise levels that samples which follow one curve are from it."""
MIN_SAMPLES = 15
"""Samples from which anything is told."""


@dataclass(frozen=True, slots=True)
class Residual:
    """The residual of n samples at rates that the curve knows.

    Attributes:
        time: (n,) [s].
        left: (n,) d − f(r), free of the usual lag [N m].
        damping, slope: (n,) f(r) [N m] and f'(r) [N m s/rad].
        doubt: (n,) standard deviation of f(r) [N m].
        torque: (n,) τ [N m].
        around: (m,) stamps [s] and torque [N m] of all samples of the batch, at any rates.
        lag: how much later than the yaw rate the torque usually comes [s], negative where earlier.
    """

    time: Array
    left: Array
    damping: Array
    slope: Array
    doubt: Array
    torque: Array
    around: tuple[Array, Array]
    lag: float

    @staticmethod
    def of(batch: Samples, known: Curve, lag: float) -> Residual:
        """The residual of a batch by the curve, with a torque that is usually `lag` [s] late."""
        inside, around = known.inside, (batch.time, batch.raw[TORQUE])
        batch = batch.take(inside)
        found = Residual(
            batch.time,
            batch.damping - known.damping[inside],
            known.damping[inside],
            known.slope[inside],
            known.doubt[inside],
            batch.raw[TORQUE],
            around,
            lag,
        )
        usual = found.torque - found.later(np.array([lag]))[0]
        return replace(found, left=found.left - np.nan_to_num(usual))

    def shape(self, cause: str, size: float) -> Array:
        """(n,) what a cause of that size leaves over [N m]; NaN where nobody knows."""
        if cause == "lag":
            usual, now = self.later(self.lag + np.array([0.0, size]))
            return np.asarray(usual - now, dtype=np.float64)
        shapes = {
            "gain": self.damping,
            "thrust": self.torque,
            "moment": np.ones(self.time.size),
            "one side": np.abs(self.damping),
            "zero": -self.slope,
        }
        found: Array = size * np.asarray(shapes[cause])
        return found

    @property
    def deviation(self) -> float:
        """Robust deviation of what is left over [N m]; infinite where the curve knows none of the rates."""
        return _deviation(self.left) if self.left.size else np.inf

    @property
    def agility(self) -> float:
        """Σ τ̇² [N² m²/s²] over the samples, of a torque that moves for half the step of the delays at least."""
        before, after = self.later(self.lag + np.array([-0.5, 0.5]) * DELAY_STEP_S)
        return float(np.nansum((after - before) ** 2)) / DELAY_STEP_S**2

    def later(self, delays: Array) -> Array:
        """(k, n) the torque each of some delays (k,) [s] later; NaN across a pause and beyond the ends."""
        time, torque = self.around
        at = self.time + delays[:, None]
        if time.size < 2:  # what is left at a recording's end
            return np.full(at.shape, np.nan)
        last = np.clip(np.searchsorted(time, at), 1, time.size - 1)
        step = np.diff(time)
        near = (step <= 2.0 * np.median(step))[last - 1] & (at >= time[0]) & (at <= time[-1])
        share = (at - time[last - 1]) / step[last - 1]
        return np.where(near, torque[last - 1] + share * (torque[last] - torque[last - 1]), np.nan)


@dataclass(frozen=True, slots=True)
class Estimate:
    """The estimated size of a cause.

    Attributes:
        size: in the cause's unit; a lag is how much later the torque comes than the yaw rate, negative where earlier.
        certainty: standard deviations between it and nothing, by what it explains.
        resolved: the least size that the samples would have shown.
        bias: how large an error of the learned curve may make it.
        unexplained: robust deviation of what it does not explain [N m].
        cost: what it does not explain, in variances: the smaller, the likelier the cause.
    """

    size: float
    certainty: float
    resolved: float
    bias: float
    unexplained: float
    cost: float


@dataclass(frozen=True, slots=True)
class Causes:
    """Every cause alone, on the same samples.

    Attributes:
        left: robust deviation of what is left over without any [N m].
        each: of each cause.
    """

    left: float
    each: dict[str, Estimate]

    @property
    def best(self) -> str:
        """The cause that explains most."""
        return min(self.each, key=lambda cause: self.each[cause].cost)

    def lead(self, cause: str) -> float:
        """The lead of a cause over the best change of the vehicle, in variances."""
        return min(self.each[other].cost for other in VEHICLE_CAUSES) - self.each[cause].cost


def causes(seen: Residual, sigma: float) -> Causes | None:
    """Weighs the causes for what is left over; None where the samples are too few.

    Args:
        sigma: noise level of a sample as learned [N m]; a batch may be noisier.
    """
    if seen.time.size < MIN_SAMPLES:
        return None
    sizes = {cause: _fitted(seen.left, seen.shape(cause, 1.0)) for cause in (*VEHICLE_CAUSES, "zero")}
    sizes["lag"] = _lag(seen, max(sigma, min(_deviation(_rest(seen, *fit)) for fit in sizes.items())))
    rests = {cause: _rest(seen, cause, size) for cause, size in sizes.items()}
    level = max(sigma, min(_deviation(rest) for rest in rests.values()))
    costs = {cause: _cost(rest, level) for cause, rest in rests.items()}
    colour = _correlation(rests[min(costs, key=lambda cause: costs[cause])])
    worth = (1.0 - colour) / (1.0 + colour)
    nothing = _cost(seen.left, level)
    errs = float(np.sum(np.maximum(seen.doubt, CURVE_ERROR_NOISES * sigma) ** 2))

    def estimate(cause: str) -> Estimate:
        power = seen.agility if cause == "lag" else float(np.sum(seen.shape(cause, 1.0) ** 2))
        doubt = level / np.sqrt(worth * power) if power > 0.0 else np.inf
        bias = np.sqrt(errs / power) if power > 0.0 else np.inf
        certainty = np.sqrt(max(worth * (nothing - costs[cause]), 0.0))
        return Estimate(
            sizes[cause], float(certainty), float(doubt), float(bias), _deviation(rests[cause]), worth * costs[cause]
        )

    return Causes(seen.deviation, {cause: estimate(cause) for cause in sizes})


def _rest(seen: Residual, cause: str, size: float) -> Array:
    """(n,) what a cause does not explain; where nobody knows what it makes, it explains nothing."""
    return seen.left - np.nan_to_num(seen.shape(cause, size))


def _lag(seen: Residual, level: float) -> float:
    """The delay of the torque beside the usual one [s] that explains most, on a grid."""
    usual = seen.later(np.array([seen.lag]))[0]
    rests = seen.left - np.nan_to_num(usual - seen.later(seen.lag + DELAYS_S))
    costs = np.minimum(rests**2, (TRIMMED_DEVIATIONS * level) ** 2).sum(axis=1)
    return float(DELAYS_S[int(np.argmin(costs))])


def agrees(batch: Samples, sigma: float) -> bool:
    """Whether the samples of a batch follow one curve of drag, be it another than was learned."""
    rate = batch.yaw_rate
    design = np.stack((rate, rate * np.abs(rate), np.ones(rate.size)), axis=1)
    kept = np.ones(rate.size, dtype=bool)
    size = np.zeros(3)
    for _ in range(3):
        size = np.linalg.lstsq(design[kept], batch.damping[kept], rcond=None)[0]
        kept = _near(batch.damping - design @ size)
    drag = design[:, :2] @ size[:2]
    return _deviation(batch.damping - design @ size) <= AGREEING_NOISES * sigma and float(drag @ rate) > 0.0


def onset_time(seen: Residual, cause: str, size: float) -> float:
    """The time [s] since which the cause explains what is left over best."""
    better = seen.left**2 - _rest(seen, cause, size) ** 2
    # samples from k on are explained by the cause, those before by nothing
    from_here = np.cumsum(better[::-1])[::-1]
    return float(seen.time[int(np.argmax(from_here))])


def _fitted(left: Array, column: Array) -> float:
    """Size of one cause by least squares without what is far off."""
    kept = np.ones(left.size, dtype=bool)
    size = 0.0
    for _ in range(3):
        square = float(column[kept] @ column[kept])
        if square <= 0.0:
            return 0.0
        size = float(column[kept] @ left[kept]) / square
        kept = _near(left - size * column)
    return size


def _near(rest: Array) -> NDArray[np.bool_]:
    kept: NDArray[np.bool_] = np.abs(rest) <= TRIMMED_DEVIATIONS * max(_deviation(rest), 1e-12)
    return kept


def _deviation(rest: Array) -> float:
    return robust_deviation(rest)


def _cost(rest: Array, level: float) -> float:
    """Sum of squares in variances; an outlier costs no more than TRIMMED_DEVIATIONS deviations."""
    return float(np.sum(np.minimum(rest**2, (TRIMMED_DEVIATIONS * level) ** 2))) / level**2


def _correlation(rest: Array) -> float:
    """Correlation of neighbours, in [0, 0.9]."""
    limit = TRIMMED_DEVIATIONS * max(_deviation(rest), 1e-12)
    rest = np.clip(rest, -limit, limit)
    power = float(rest @ rest)
    return min(max(float(rest[1:] @ rest[:-1]) / power, 0.0), 0.9) if power > 0.0 else 0.0
