"""What changed, or is wrong, of a window of samples: every cause weighed at every onset by its marginal likelihood.

Of e = d − f(r), what the learned curve leaves over, each cause makes a shape of its own from its onset on:

    damping      e ∝ f(r)       thrust     e ∝ τ          a vehicle may do both: they are told, and learned
    moment       e ∝ 1          one side   e ∝ |f(r)|     the same
    zero         e ∝ −f'(r)     no vehicle shifts its curve along the yaw rate: a gyro's zero does
    lag          e = τ(t) − τ(t + δ)                      clocks come apart
    sign         e = 2 τ        one of the streams counts the other way

Nothing, too, has its shapes: the curve errs about each rate, the thrust is known to some hundredths, and how late the
torque usually comes is known so well. With uniform priors over onsets and delays, ln p(e | cause) − ln p(e | nothing)
is the evidence of a family; a sample far off costs no more than TRIMMED_DEVIATIONS deviations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from incsvr.checks.curve import Curve
from incsvr.checks.evidence import Evidence
from incsvr.numerics import Array, independent_part, robust_deviation
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

VEHICLE_CAUSES = ("damping", "thrust", "moment", "one side")
"""Causes that are a change of the vehicle."""
SENSOR_CAUSES = ("zero", "lag", "sign")
"""Causes that are a fault of a sensor."""
AGES = (12, 18, 25, 37, 50, 75, 100)
"""Samples since the onsets that are tried, of which a cause touches as many as the fewest: a stray one or two make
none."""
TRIMMED_DEVIATIONS = 3.5
"""Deviations beyond which a sample costs no more."""
ALIKE = 4.0
"""ln of odds within which two causes are told as one or the other."""
KNOTS = 6
"""Rates about which the learned curve errs, each by itself."""
CURVE_ERROR_NOISES = 0.3
"""Its error there in noise levels, at least."""
THRUST_ERROR = 0.03
"""Deviation of the thrust, as a part of it, while nothing happens."""
DELAY_STEP_S = 0.125
"""Step between two delays of the torque that are tried [s]."""
DELAYS_S: Array = DELAY_STEP_S * np.arange(-32.0, 33.0, dtype=np.float64)
"""Delays that are tried beside the usual one [s]: beyond, torque and yaw rate do not belong together at all."""


LAG_TURN = -1
"""Place of the usual lag among what nothing leaves over."""
NAMES = ("damping", "thrust", "moment", "one side", "zero", "sign") + ("lag",) * DELAYS_S.size
"""The family of each member."""


@dataclass(frozen=True, slots=True)
class Cause:
    """A family of causes, weighed.

    Attributes:
        odds: ln of its evidence over that of nothing.
        size: of its likeliest member, in the cause's unit.
        since: the likeliest onset [s].
        left: robust deviation of what it leaves over since then [N m].
    """

    odds: float
    size: float
    since: float
    left: float


@dataclass(frozen=True, slots=True)
class Causes:
    """All families on one window.

    Attributes:
        each: by name.
        left: robust deviation of what the curve leaves over in the whole window [N m].
        least: the same of what the best member leaves over since an onset, the largest of the onsets [N m].
        level: noise level since the last onsets [N m].
        lag: how much later the torque comes than it usually does, and its deviation [s], by these samples alone.
        zero: deviation of a gyro's zero, likewise [rad/s].
    """

    each: dict[str, Cause]
    left: float
    least: float
    lag: tuple[float, float]
    zero: float

    def alike(self, names: tuple[str, ...]) -> list[str]:
        """Those of some causes that explain about as much as the best of them, the plainest first."""
        best = max(self.each[name].odds for name in names)
        return [name for name in names if self.each[name].odds > best - ALIKE]


@dataclass(frozen=True, slots=True)
class Window:
    """n samples at rates that the curve knows.

    Attributes:
        time, left: (n,) [s], d − f(r) free of the usual lag [N m].
        shapes: (members, n) what each member of each cause leaves over.
        usual: (n, m) what is left over all the same, the usual lag last.
        spread: (m,) deviations of how much of it.
    """

    time: Array
    left: Array
    shapes: Array
    usual: Array
    spread: Array

    @staticmethod
    def of(batch: Samples, known: Curve, lag: float, doubt: float, largest_rate: float) -> Window:
        """The window of samples with the curve at their rates.

        Args:
            lag, doubt: how much later than the yaw rate the torque usually comes, and its deviation [s].
        """
        inside = known.inside
        time, torque, rate = batch.time[inside], batch.raw[TORQUE][inside], batch.yaw_rate[inside]
        f, slope = known.damping[inside], known.slope[inside]
        half = 0.5 * DELAY_STEP_S
        usually = _later(batch, time, np.array([lag]), torque)[0]
        before, after, *later = _later(batch, time, lag + np.concatenate(([-half, half], DELAYS_S)), usually)
        place = 0.5 * (rate / largest_rate + 1.0) * (KNOTS - 1)
        near = np.maximum(1.0 - np.abs(place[:, None] - np.arange(KNOTS)), 0.0)
        errs = max(float(np.median(known.doubt[inside])) if time.size else 0.0, CURVE_ERROR_NOISES * known.sigma)
        return Window(
            time,
            batch.damping[inside] - f - (torque - usually),
            np.stack(
                [f, torque, np.ones(time.size), np.abs(f), -slope, 2.0 * torque, *(usually - each for each in later)]
            ),
            np.column_stack((near, torque, (before - after) / DELAY_STEP_S)),
            np.array([errs] * KNOTS + [THRUST_ERROR, doubt]),
        )


def _later(batch: Samples, at: Array, delays: Array, then: Array) -> Array:
    """(k, n) the torque at (n,) times, each of some delays (k,) [s] later; `then` across pauses and beyond ends."""
    time, torque = batch.time, batch.raw[TORQUE]
    if time.size < 2:
        return np.tile(then, (delays.size, 1))
    at = at + delays[:, None]
    last = np.clip(np.searchsorted(time, at), 1, time.size - 1)
    step = np.diff(time)
    near = (step <= 2.0 * np.median(step))[last - 1] & (at >= time[0]) & (at <= time[-1])
    share = (at - time[last - 1]) / step[last - 1]
    return np.where(near, torque[last - 1] + share * (torque[last] - torque[last - 1]), then)


def causes(seen: Window, sigma: float, largest: float, largest_rate: float) -> Causes | None:
    """Weighs the causes; None where the samples are too few.

    Args:
        sigma: noise level of a sample as learned [N m]; a window may be noisier.
        largest, largest_rate: that was learned [N m], that the vehicle reaches [rad/s].
    """
    n = seen.time.size
    if n < 2 * AGES[0]:
        return None
    mean = np.array([0.0] * 5 + [1.0] * (1 + DELAYS_S.size))
    spread = np.array([0.4, 0.4, 0.3 * largest, 0.4, 0.2 * largest_rate, 0.05] + [0.1] * DELAYS_S.size)
    ages = sorted({min(age, n) for age in AGES})
    whole = _Fit.of(seen, n, mean, spread, sigma, 0.0)
    colour = _correlation(whole.rest[int(np.argmax(np.append(whole.said.odds, 0.0)))])
    fits = [_Fit.of(seen, age, mean, spread, sigma, colour) for age in ages]
    touched = [np.count_nonzero(seen.shapes[:, -age:], axis=1) >= AGES[0] for age in ages]
    odds = np.array([np.where(enough, fit.said.odds, -np.inf) for fit, enough in zip(fits, touched, strict=True)])
    names = np.array(NAMES)
    each = {}
    for name in dict.fromkeys(NAMES):
        own = np.flatnonzero(names == name)
        table = odds[:, own]
        if not np.isfinite(table).any():
            each[name] = Cause(-np.inf, 0.0, float(seen.time[0]), float(fits[-1].far[own[0]]))
            continue
        k, j = np.unravel_index(int(np.argmax(table)), table.shape)
        top, member = float(table.max()), int(own[j])
        size = float(DELAYS_S[j] if name == "lag" else fits[k].said.size[member])
        evidence = top + float(np.log(np.mean(np.exp(table - top))))
        each[name] = Cause(evidence, size, float(seen.time[n - ages[k]]), float(fits[k].far[member]))
    usual, known = fits[-1].said, seen.spread[LAG_TURN]
    doubt = float(np.linalg.inv(usual.precision)[LAG_TURN, LAG_TURN])
    told = max(1.0 / doubt - known**-2.0, 1e-12)  # without what was known before
    shifted = max(float(seen.shapes[NAMES.index("zero")] @ seen.shapes[NAMES.index("zero")]), 1e-300)
    return Causes(
        each,
        robust_deviation(seen.left),
        max(float(fit.far.min()) for fit in fits),
        (float(usual.usual[LAG_TURN, -1]) / doubt / told, told**-0.5),
        fits[-1].level * float(independent_part(colour) * shifted) ** -0.5,
    )


@dataclass(frozen=True, slots=True)
class _Fit:
    """Every member beside what is usual on the last samples of a window.

    Attributes:
        said: the evidence of each.
        rest: (members + 1, n) what each leaves over, and nothing [N m].
        far: (members + 1,) its robust deviation [N m].
        level: noise level of the samples [N m].
    """

    said: Evidence
    rest: Array
    far: Array
    level: float

    @staticmethod
    def of(seen: Window, age: int, mean: Array, spread: Array, sigma: float, colour: float) -> _Fit:
        shapes, usual, left = seen.shapes[:, -age:], seen.usual[-age:].T, seen.left[-age:]
        columns, directions = np.concatenate((usual, shapes, left[None, :])), np.eye(len(usual) + len(shapes))
        prior, weight, level = np.diag(seen.spread**-2.0), np.ones(left.size), sigma
        for _ in range(3):
            sums = columns @ (columns * (weight * independent_part(colour) / level**2)).T
            said = Evidence.of(sums, prior, directions[:, len(usual) :], mean, spread)
            rest = left - said.usual.T @ usual
            rest[:-1] -= said.size[:, None] * shapes
            far = np.median(np.abs(rest), axis=1) / 0.6745
            level = max(sigma, float(far.min()))
            best = int(np.argmax(np.append(said.odds, 0.0)))
            weight = np.abs(rest[best]) <= TRIMMED_DEVIATIONS * max(float(far[best]), level)
        # a cause that a few samples ask for, each by far, is none
        cost = independent_part(colour) * np.sum(np.minimum((rest / level) ** 2, TRIMMED_DEVIATIONS**2), axis=1)
        cost += np.sum((said.usual / seen.spread[:, None]) ** 2, axis=0)
        cost[:-1] += ((said.size - mean) / spread) ** 2
        odds = 0.5 * (cost[-1] - cost[:-1]) + np.log(said.deviation / spread)
        return _Fit(replace(said, odds=odds), rest, far, level)


def _correlation(rest: Array) -> float:
    """Correlation of neighbours, in [0, 0.9]."""
    limit = TRIMMED_DEVIATIONS * max(robust_deviation(rest), 1e-12)
    rest = np.clip(rest, -limit, limit)
    power = float(rest @ rest)
    return min(max(float(rest[1:] @ rest[:-1]) / power, 0.0), 0.9) if power > 0.0 else 0.0
