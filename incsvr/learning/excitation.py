"""Which motion is evidence about damping: that which the torque makes, not that which the water makes.

A damping sample y = τ − I ṙ is d(r) − w, with w the moment of the water. Where the torque turns the vehicle, w is
noise. Where w turns it, a sample tells the water with its sign turned, and, where a controller holds the vehicle, the
controller's gain: regression in closed loop is biased (L. Ljung, System Identification, 2nd ed., ch. 13). What tells
them apart is work. Over a window the torque's work less the rise of ½ I r² is Σ y r: what damping has taken, less what
the water has put in. Damping takes work from every motion; so where Σ y r is not clearly positive the water has made
the motion. "Clearly" is Student's t of the slope of y over r through the origin, for noise of the correlation seen.

The same holds for the motion about the window's mean. Where its work is negative, at a turn held for long, the mean is
evidence and the motion about it is not: the samples stand at the mean rate then (A. Wald, Ann. Math. Stat. 11,
1940: grouping by what the errors do not know, here by time).

Nothing is known of the vehicle here but Eq. 5, and a batch needs the last samples of the one before it at most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from incsvr.learning.criteria import Mask
from incsvr.samples import Array, Samples

WINDOW = 11
"""Samples over which work is weighed: several of the vehicle's time scales where they stand as the paper's do."""
MOSTLY = 0.5
"""Share of a batch that the torque makes from which all of it is evidence: the water then bends the curve by less than
leaving samples out by what they say."""

CLEARLY = 3.0
"""Student's t from which on the work is clearly positive: by chance in one window of about 150."""
HELD = 1.0
"""Student's t below whose negative the motion about the mean is the water's. By chance in one window of six of noise
alone; but at the crests of the paper's experiment, where the rate moves least, in none of a thousand."""
AT_REST = 0.25
"""A sample whose neighbourhood moves by less than this share of its window is at rest beside a turn, and no evidence;
a straight pass through zero, as in the paper's experiment, has 0.26."""
LITTLE = 0.05
"""Where less than this part of the samples is evidence, somebody should know."""
HORIZON = 1000.0
"""Samples that the running means of the water stand for, at most."""
LARGEST_CORRELATION = 0.95
"""Of the noise of two neighbours, as far as it is believed."""


@dataclass(frozen=True, slots=True)
class Recent:
    """What the next batch needs of those before it: their last samples, fewer than WINDOW.

    Attributes:
        yaw_rate: (n,) [rad/s].
        damping: (n,) [N m].
    """

    yaw_rate: Array
    damping: Array

    @staticmethod
    def empty() -> Recent:
        return Recent(np.empty(0), np.empty(0))

    def to_dict(self) -> dict[str, Any]:
        return {"yaw_rate": self.yaw_rate.tolist(), "damping": self.damping.tolist()}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Recent:
        return Recent(*(np.array(data[name], dtype=np.float64) for name in ("yaw_rate", "damping")))


@dataclass(frozen=True, slots=True)
class Water:
    """What motion was no evidence: running means over all samples, to which those that are evidence add nothing.

    Attributes:
        rate: mean r² of it [rad²/s²].
        moment: mean y² of it [N² m²]: of about the water's own moment.
        share: of the samples, in 0 to 1.
        seen: samples that the means stand for.
    """

    rate: float = 0.0
    moment: float = 0.0
    share: float = 0.0
    seen: float = 0.0

    def after(self, batch: Samples, driven: Mask) -> Water:
        """With a batch of n ≥ 1 samples."""
        n = len(batch)
        rate, moment = float((batch.yaw_rate**2) @ ~driven), float((batch.damping**2) @ ~driven)
        count = float(np.count_nonzero(~driven))
        known = min(self.seen, max(HORIZON - n, 0.0))
        seen = known + n
        return Water(
            (known * self.rate + rate) / seen,
            (known * self.moment + moment) / seen,
            (known * self.share + count) / seen,
            seen,
        )

    def to_list(self) -> list[float]:
        return [self.rate, self.moment, self.share, self.seen]

    @staticmethod
    def from_list(data: Sequence[float]) -> Water:
        rate, moment, share, seen = data
        return Water(rate, moment, share, seen)


@dataclass(frozen=True, slots=True)
class Excitation:
    """How much of some samples is evidence about damping.

    Attributes:
        driven: samples whose motion the torque made.
        samples: of all.
        fastest: largest |r| among all [rad/s].
        driven_rates: lowest and highest rate of the driven ones [rad/s]; None where there is none.
    """

    driven: int
    samples: int
    fastest: float
    driven_rates: tuple[float, float] | None

    @staticmethod
    def of(batch: Samples, undriven: Samples) -> Excitation:
        """Of a batch of n ≥ 1 samples, some of them undriven."""
        rates = batch.yaw_rate[~np.isin(batch.time, undriven.time)]
        driven_rates = (float(rates.min()), float(rates.max())) if rates.size else None
        return Excitation(rates.size, len(batch), float(np.abs(batch.yaw_rate).max()), driven_rates)

    @staticmethod
    def together(parts: Sequence[Excitation]) -> Excitation:
        """Of several batches, at least one."""
        rates = [part.driven_rates for part in parts if part.driven_rates is not None]
        return Excitation(
            sum(part.driven for part in parts),
            sum(part.samples for part in parts),
            max(part.fastest for part in parts),
            (min(low for low, _ in rates), max(high for _, high in rates)) if rates else None,
        )

    @property
    def sentence(self) -> str:
        """What there is, with its figures."""
        if self.driven_rates is None:
            return f"the torque made none of the motion of {self.samples} samples, up to {self.fastest:.3g} rad/s"
        low, high = self.driven_rates
        return (
            f"the torque made the motion of {self.driven} of {self.samples} samples "
            f"({100.0 * self.driven / self.samples:.2g} %), at {low:.3g} to {high:.3g} rad/s"
        )

    @property
    def little(self) -> bool:
        """Whether so few samples are evidence that somebody should know."""
        return self.driven < LITTLE * self.samples


MANOEUVRE = (
    "drive steps of torque to both sides, from weak to full, each held until the yaw rate has settled, for some minutes"
)
"""What would be evidence."""


def torque_answers(undriven: Samples) -> bool:
    """Whether a controller has closed the loop: where the water makes the motion, y is −K r then, and nothing else is.

    In open loop, where ṙ is as often positive as negative at every rate, y averages to the torque, which does not know
    the rate. Motion that the torque makes throughout tells nothing of the kind: then this says no.
    """
    r, y = undriven.yaw_rate, undriven.damping
    motion, work = float(r @ r), float(r @ y)
    if r.size < WINDOW or not motion > 0.0:
        return False
    left = y - work / motion * r
    return work < 0.0 and r.size * _worth(left) * work * work > CLEARLY**2 * motion * float(left @ left)


class Sifted(NamedTuple):
    """What a batch tells.

    Attributes:
        driven: (n,) which of its samples are evidence about damping.
        yaw_rate: (n,) the rate at which each is [rad/s]: its own, or its window's mean.
        recent: for the next batch.
    """

    driven: Mask
    yaw_rate: Array
    recent: Recent


def sift(batch: Samples, recent: Recent) -> Sifted:
    """Tells what of a batch of n ≥ 1 samples the torque has made.

    A window is centred on its sample, but within the batch and the samples before it: nothing waits for the future.
    """
    r = np.concatenate((recent.yaw_rate, batch.yaw_rate))
    y = np.concatenate((recent.damping, batch.damping))
    kept = Recent(r[1 - WINDOW :], y[1 - WINDOW :])
    if r.size < 3:  # too few to tell
        return Sifted(np.ones(len(batch), dtype=bool), batch.yaw_rate, kept)
    count = min(WINDOW, r.size)
    first = np.clip(np.arange(r.size) - count // 2, 0, r.size - count)
    rates, moments = (sliding_window_view(values, count)[first] for values in (r, y))
    motion = (rates * rates).sum(axis=1)
    moments = _tamed(moments, _slope(moments, rates, motion) * rates)
    work, power = (moments * rates).sum(axis=1), (moments * moments).sum(axis=1)
    slope = _slope(moments, rates, motion)[:, 0]
    worth = (count - 1) * _worth(y - slope * r)
    # t² = worth (Σyr)² / (Σy² Σr² − (Σyr)²), without a division.
    clear = (work > 0.0) & (worth * work * work > CLEARLY**2 * (power * motion - work * work))
    beside = np.clip(np.arange(r.size) - 1, 0, r.size - 3)
    near = (sliding_window_view(r, 3)[beside] ** 2).mean(axis=1)
    moves = near >= AT_REST**2 * motion / count
    mean = rates.mean(axis=1)
    about, level = rates - mean[:, None], moments - moments.mean(axis=1)[:, None]
    work, motion, power = (about * level).sum(axis=1), (about * about).sum(axis=1), (level * level).sum(axis=1)
    held = (work < 0.0) & (worth * work * work > HELD**2 * (power * motion - work * work))
    new = slice(recent.yaw_rate.size, None)
    driven = (clear & moves)[new]
    if driven.mean() > MOSTLY:
        return Sifted(np.ones(len(batch), dtype=bool), batch.yaw_rate, kept)
    return Sifted(driven, np.where(held, mean, r)[new], kept)


def _slope(moments: Array, rates: Array, motion: Array) -> Array:
    """(n, 1) slope of (n, m) moments over rates through the origin, Σ r² = motion (n,); 0 where nothing moves."""
    work = (moments * rates).sum(axis=1)
    slope = np.divide(work, motion, out=np.zeros(motion.size), where=motion > 0.0)
    return np.asarray(slope[:, None])


def _tamed(moments: Array, line: Array) -> Array:
    """(n, m) moments, of which the one farthest from the line in each window is as far as the second: one outlier must
    not hide what ten samples say."""
    error = moments - line
    limit = np.partition(np.abs(error), -2, axis=1)[:, -2:-1]
    clipped = np.minimum(np.maximum(error, -limit), limit)
    return np.asarray(line + clipped)


def _worth(error: Array) -> float:
    """How many independent samples one of (n,) errors is worth in a mean: (1 − ρ)/(1 + ρ)."""
    power = float(error @ error)
    correlation = float(error[1:] @ error[:-1]) / power if power > 0.0 else 0.0
    correlation = min(max(correlation, 0.0), LARGEST_CORRELATION)
    return (1.0 - correlation) / (1.0 + correlation)
