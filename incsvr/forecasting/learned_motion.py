"""A served model's motion on the engine: its damping as rows, beside traced effects and the rest of a body.

    I ṙ + d(r) + Σ effects + a + b r = τ

Over one velocity d is a curve. Over several, of which the others are given along time, it is a table of time and rate,
taken apart into products of a function of time and a curve of the rate (its singular values).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.learning.model import Model
from incsvr.model.factors import Indices
from incsvr.model.rows import ONE, Factor, Part, Row, value
from incsvr.model.series import effort_of
from incsvr.model.simulation import Course, simulate
from incsvr.model.structure import Structure
from incsvr.model.windows import beginning_at
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import YAW
from incsvr.tracing.model import TracedModel

OUTSIDE, LINEAR = "body:outside", "body:linear"
"""Streams of a [N m] and b [N m s], which the rest of a body takes."""
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
        rates, width = _rates(fastest, RATES if model.several is None else RATES_AMONG_OTHERS)
        if model.several is None:
            said = model.predict(rates)
            return LearnedDamping(width, time[:1], said.damping[None], said.doubt[None])
        span = float(time[-1] - time[0])
        at = np.linspace(time[0], time[-1], min(math.ceil(span / MAX_TABLE_PERIOD_S) + 1, MAX_TABLES))
        beside = np.column_stack([np.interp(at, time, column) for column in others.T])
        said = model.over(np.column_stack((np.tile(rates, at.size), np.repeat(beside, rates.size, axis=0))))
        damping, doubt = (each.reshape(at.size, -1) for each in (said.damping, said.doubt))
        return LearnedDamping(width, at, damping, doubt)

    @staticmethod
    def curve(damping: Callable[[Array], Array], fastest: float) -> LearnedDamping:
        """A curve d(r), (n,) rad/s → (n,) N m, without doubt, out to REACH times the fastest rate [rad/s]."""
        rates, width = _rates(fastest, RATES)
        table = damping(rates)[None]
        return LearnedDamping(width, np.zeros(1), table, np.zeros_like(table))

    def time_constant(self, inertia: float) -> float:
        """The shortest of the motion [s], of an inertia [kg m²]."""
        steepest = float(np.abs(np.diff(self.damping, axis=1)).max()) / self.width
        return inertia / max(steepest, 1e-12)

    def rows(self, axis: str) -> tuple[tuple[Row, ...], Streams]:
        """The rows of an axis, whose coefficients are 1, and the channels that they read."""
        if self.at.size == 1:
            return (_row(axis, self.width, self.damping[0]),), {}
        left, sizes, curves = np.linalg.svd(self.damping, full_matrices=False)
        kept = np.flatnonzero(sizes > MIN_PART * sizes[0]).tolist()
        channels = {f"learned:{k}": (self.at, sizes[k] * left[:, k]) for k in kept}
        rows = zip(channels, (curves[k] for k in kept), strict=True)
        return tuple(_row(axis, self.width, curve, name) for name, curve in rows), channels

    def doubt_at(self, time: Array, rate: Array) -> Array:
        """One standard deviation of the damping at instants [s] and rates [rad/s] of one shape [N m]."""
        table = np.rint(np.interp(time, self.at, np.arange(self.at.size))).astype(np.intp)
        place = np.clip(rate / self.width + 0.5 * (self.doubt.shape[1] - 1), 0.0, self.doubt.shape[1] - 1.0)
        return np.asarray(self.doubt[table, np.rint(place).astype(np.intp)])


def _rates(fastest: float, count: int) -> tuple[Array, float]:
    """The rates of a table, and the width between two [rad/s]."""
    rates = np.linspace(-REACH * fastest, REACH * fastest, count)
    return rates, float(rates[1] - rates[0])


def simulated(
    damping: LearnedDamping,
    inertia: float,
    run: Streams,
    step: float,
    first: Indices,
    steps: int,
    rate: Array,
    effects: TracedModel | None = None,
) -> Course:
    """Free runs under a learned damping, side by side.

    Args:
        inertia: as it is declared [kg m²].
        run: the velocity on edges a step [s] apart, the effort, what the effects read by the engine's names, and what
            the rest of a body takes, where anything does.
        first: (n,) the edges at which the runs begin.
        steps: of the longest; the last edge ends those that begin late.
        rate: (n,) where they begin [rad/s].
        effects: traced ones; None for none.
    """
    axis = YAW.rate if effects is None else effects.axis
    rows, channels = damping.rows(axis)
    for name, other in ((OUTSIDE, ONE), (LINEAR, value(axis))):
        if name in run:
            rows = (*rows, Row(name, (Part(axis, value(name), other),)))
    run = {**run, **channels}
    read = tuple(name for name in run if name not in (axis, effort_of(axis)))
    structure = Structure((axis,), (axis,), rows, given={axis: math.log(inertia)}, channels=read)
    theta = {row.key: 1.0 for row in rows}
    if effects is not None:
        structure, theta = effects.added_to(structure), {**theta, **effects.theta}
        run = {**run, effort_of(axis): effects.acting(run[effort_of(axis)])}
    windows = beginning_at(run, structure, step, first, steps)
    return simulate(structure, np.array([theta[name] for name in structure.names]), windows, rate[None])


def _row(axis: str, width: float, curve: Array, scaled_by: str = "") -> Row:
    """A curve of an axis's own velocity by its values `width` apart, the middle one at rest, times a channel."""
    own = Factor("curve", axis, width, tuple(curve.tolist()))
    return Row(scaled_by or "learned", (Part(axis, own, value(scaled_by) if scaled_by else ONE),))
