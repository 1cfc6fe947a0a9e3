"""A served model's damping as tables, quick enough for every step of many free runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.model import Model
from incsvr.numerics import Array

TABLE_NODES = 2001
"""Rates at which a curve is tabulated."""
TABLE_REACH = 2.5
"""Ends of the table, in fastest rates: a free run that is beyond is no forecast of anything."""
MIN_CORRELATION = 0.05
"""Correlation of the noise of two samples, at least: less cannot be told from none, and would be a time of nearly
nothing."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A model's damping in even steps of the rate, and what noise its samples have.

    Attributes:
        low, step: the rates are low, low + step, … [rad/s].
        damping, slope, sigma: (TABLE_NODES,) d(r) [N m], d′(r) [N m s/rad], one standard deviation of the curve [N m].
        inertia: I [kg m²].
        disturbance: one standard deviation of w [N m].
        lasts: its correlation time [s].
        linear: (steps + 1, n) b [N m s], what the rest of the body takes in proportion to the rate in each step of n
            runs; None for nothing.
    """

    low: float
    step: float
    damping: Array
    slope: Array
    sigma: Array
    inertia: float
    disturbance: float
    lasts: float
    linear: Array | None = None

    @staticmethod
    def of(model: Model, inertia: float, fastest: float, period: float, linear: Array | None = None) -> Curve:
        """A trained model's, out to TABLE_REACH times the fastest rate [rad/s]; `period` is between two samples [s]."""
        rates = np.linspace(-TABLE_REACH * fastest, TABLE_REACH * fastest, TABLE_NODES)
        said = model.predict(rates)
        step = float(rates[1] - rates[0])
        # A free run must not gain energy: where a curve drives, by its own doubt, it is taken for a flat one.
        slope = np.maximum(np.gradient(said.damping, step), 0.0)
        return Curve(
            float(rates[0]), step, said.damping, slope, said.doubt, inertia, float(model.sigma),
            lasting(model, period), linear,
        )  # fmt: skip

    def at(self, rate: Array, k: int = 0) -> tuple[Array, Array, Array]:
        """Damping, slope and doubt at (n,) rates in step k, those of the ends beyond them."""
        place = np.clip((rate - self.low) / self.step, 0.0, TABLE_NODES - 1.001)
        cell = place.astype(np.intp)
        part = place - cell
        damping = self.damping[cell] + part * (self.damping[cell + 1] - self.damping[cell])
        return with_linear(damping, self.slope[cell], self.sigma[cell], rate, self.linear, k)


MAX_TABLE_PERIOD_S = 0.5
"""Time between two tables of a damping that goes by other velocities, too [s]: a hull's speed hardly bends within."""
MAX_TABLES = 300
"""Tables of one forecast at most: over many minutes they stand further apart."""
TABLE_RATES = 121
"""Rates of each of these tables; a quadratic drag is off by less than a thousandth between two."""


@dataclass(frozen=True, slots=True)
class CurveAmongOthers:
    """The damping of a model over several velocities along n runs; what `Curve` has, too, is as there.

    Attributes:
        low, step: the rates of the tables are low, low + step, … [rad/s].
        damping, slope, sigma: (tables, TABLE_RATES) at even times.
        place: (steps + 1, n) where each run stands among the tables.
    """

    low: float
    step: float
    damping: Array
    slope: Array
    sigma: Array
    place: Array
    inertia: float
    disturbance: float
    lasts: float
    linear: Array | None = None

    @staticmethod
    def of(
        model: Model,
        others: Array,
        rows: NDArray[np.intp],
        grid_step: float,
        inertia: float,
        fastest: float,
        period: float,
        linear: Array | None = None,
    ) -> CurveAmongOthers:
        """The table of a curve, as of `Curve.of`.

        Args:
            others: (points, d − 1) the model's further velocities on a grid.
            rows: (steps + 1, n) the points of the grid along each run.
            grid_step: of the grid [s].
        """
        first, last = int(rows.min()), int(rows.max())
        count = min(math.ceil((last - first) * grid_step / MAX_TABLE_PERIOD_S) + 1, MAX_TABLES)
        at = np.linspace(first, last, count)
        points = np.arange(others.shape[0])
        beside = np.column_stack([np.interp(at, points, column) for column in others.T])
        rates = np.linspace(-TABLE_REACH * fastest, TABLE_REACH * fastest, TABLE_RATES)
        said = model.over(np.column_stack((np.tile(rates, count), np.repeat(beside, TABLE_RATES, axis=0))))
        damping, sigma = (each.reshape(count, TABLE_RATES) for each in (said.damping, said.doubt))
        step = float(rates[1] - rates[0])
        slope = np.maximum(np.gradient(damping, step, axis=1), 0.0)
        place = np.asarray((rows - first) * ((count - 1) / max(last - first, 1)), dtype=np.float64)
        return CurveAmongOthers(
            float(rates[0]), step, damping, slope, sigma, place, inertia, float(model.sigma),
            lasting(model, period), linear,
        )  # fmt: skip

    def at(self, rate: Array, k: int = 0) -> tuple[Array, Array, Array]:
        """Damping, slope and doubt at (n,) rates in step k, those of the ends beyond them."""
        place = np.clip((rate - self.low) / self.step, 0.0, TABLE_RATES - 1.001)
        cell = place.astype(np.intp)
        table = np.minimum(self.place[k].astype(np.intp), max(self.damping.shape[0] - 2, 0))
        after = np.minimum(table + 1, self.damping.shape[0] - 1)
        part, late = place - cell, self.place[k] - table
        early, later = (
            self.damping[row, cell] + part * (self.damping[row, cell + 1] - self.damping[row, cell])
            for row in (table, after)
        )
        slope = (1.0 - late) * self.slope[table, cell] + late * self.slope[after, cell]
        return with_linear(early + late * (later - early), slope, self.sigma[table, cell], rate, self.linear, k)


def lasting(model: Model, period: float) -> float:
    """Correlation time of what a model's samples have of the water [s], which come every `period` [s]."""
    return -period / math.log(min(max(model.correlation, MIN_CORRELATION), 0.999))


def with_linear(
    damping: Array, slope: Array, sigma: Array, rate: Array, linear: Array | None, k: int
) -> tuple[Array, Array, Array]:
    """The table with the body's torque in proportion to the rate, which may also drive."""
    if linear is None:
        return damping, slope, sigma
    return damping + linear[k] * rate, slope + linear[k], sigma
