"""A served model's damping as rows of the engine, quick enough for every step of many free runs.

Over one velocity it is a curve. Over several, of which the others are given along time, it is a table of time and rate,
taken apart into products of a function of time and a curve of the rate (its singular values).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from incsvr.compensation.traced_motion import learned_row
from incsvr.learning.model import Model
from incsvr.model.rows import Row
from incsvr.numerics import Array, Streams

REACH = 2.5
"""Ends of a table, in fastest rates: a free run that is beyond is no forecast of anything."""
RATES, RATES_AMONG_OTHERS = 1001, 121
"""Rates of a table over one velocity, and over several: a quadratic drag is off by less than a thousandth between."""
MAX_TABLE_PERIOD_S = 0.5
"""Time between two tables of a damping that goes by other velocities, too [s]: a hull's speed hardly bends within."""
MAX_TABLES = 300
"""Tables of one forecast at most: over many minutes they stand further apart."""
MIN_PART = 1e-6
"""Part of the largest singular value below which one is left out."""


@dataclass(frozen=True, slots=True)
class LearnedDamping:
    """A model's damping at even rates about zero, and at (k,) instants where it goes by other velocities, too.

    Attributes:
        width: between two rates [rad/s].
        at: (k,) the instants [s]; one of a damping that does not change.
        damping, doubt: (k, rates) d [N m], and one standard deviation of it [N m].
    """

    width: float
    at: Array
    damping: Array
    doubt: Array

    @staticmethod
    def of(model: Model, fastest: float, time: Array, others: Array) -> LearnedDamping:
        """A trained model's, out to REACH times the fastest rate [rad/s].

        Args:
            time: (n,) [s], n ≥ 1.
            others: (n, d − 1) the model's further velocities then.
        """
        several = model.several is not None
        places = np.arange(RATES_AMONG_OTHERS if several else RATES)
        width = 2.0 * REACH * fastest / (places.size - 1)
        rates = np.asarray(width * (places - places[-1] // 2), dtype=np.float64)
        if not several:
            said = model.predict(rates)
            return LearnedDamping(width, time[:1], said.damping[None], said.doubt[None])
        span = float(time[-1] - time[0])
        at = np.linspace(time[0], time[-1], min(math.ceil(span / MAX_TABLE_PERIOD_S) + 1, MAX_TABLES))
        beside = np.column_stack([np.interp(at, time, column) for column in others.T])
        said = model.over(np.column_stack((np.tile(rates, at.size), np.repeat(beside, rates.size, axis=0))))
        damping, doubt = (each.reshape(at.size, -1) for each in (said.damping, said.doubt))
        return LearnedDamping(width, at, damping, doubt)

    @property
    def steepest(self) -> float:
        """The largest slope [N m s/rad]."""
        return float(np.abs(np.diff(self.damping, axis=1)).max()) / self.width

    def rows(self, axis: str) -> tuple[tuple[Row, ...], Streams]:
        """The rows of an axis, whose coefficients are 1, and the channels that they read."""
        if self.at.size == 1:
            return (learned_row(axis, self.width, self.damping[0]),), {}
        left, sizes, curves = np.linalg.svd(self.damping, full_matrices=False)
        kept = np.flatnonzero(sizes > MIN_PART * sizes[0]).tolist()
        channels = {f"learned:{k}": (self.at, sizes[k] * left[:, k]) for k in kept}
        rows = zip(channels, (curves[k] for k in kept), strict=True)
        return tuple(learned_row(axis, self.width, curve, name) for name, curve in rows), channels

    def doubt_at(self, time: Array, rate: Array) -> Array:
        """One standard deviation of the damping at instants [s] and rates [rad/s] of one shape [N m]."""
        table = np.rint(np.interp(time, self.at, np.arange(self.at.size))).astype(np.intp)
        place = np.clip(rate / self.width + 0.5 * (self.doubt.shape[1] - 1), 0.0, self.doubt.shape[1] - 1.0)
        return np.asarray(self.doubt[table, np.rint(place).astype(np.intp)])
