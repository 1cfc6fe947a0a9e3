"""The motion that a model predicts from measured rates, side by side over many windows.

    (I₀ + ΔI) ṙ = T(τ) − f d(r) − Σ moments(r, ψ, water, channels)

Windows are spans of cells, simulated from the measured rate, heading and water at their beginning: of one cell
(innovations), of a time scale (windows), or of a whole recording (a free run). Integrator: exponential
Rosenbrock–Euler, second order (M. Hochbruck, A. Ostermann, Acta Numerica 19, 2010); dry friction by G. Strang's
splitting (SIAM J. Numer. Anal. 5, 1968), because a friction so steep would stall every reversal for a step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals
from incsvr.effects.even_table import EvenTable
from incsvr.effects.signals import MIN_SLOPE
from incsvr.numerics import Array
from incsvr.tracing.cells import Cells
from incsvr.tracing.hypothesis import Part

MAX_RATE_FACTOR = 5.0
"""Fastest rates of the recordings within which a simulation is held: divergence stays finite."""
DRAG_TABLE_CELLS = 1000
"""Cells of the table of d(r), to either side."""
RATE_NUDGE_SHARE = 1e-4
"""Part of the fastest rate over which slopes are taken."""
MAX_EXPONENT = 50.0
"""Exponent of one step of the integrator at most: beyond, a simulation diverges anyway."""
MIN_EXPONENT = 1e-6
"""Exponent of one step at least: below, eᶻ − 1 has lost its digits."""


@dataclass(frozen=True, slots=True)
class Windows:
    """Spans of cells that are simulated side by side.

    Attributes:
        first: (w,) first cell of each.
        steps: (w,) how many cells each has.
    """

    first: NDArray[np.intp]
    steps: NDArray[np.intp]

    @staticmethod
    def of(slices: Sequence[slice]) -> Windows:
        """Each slice of the cells as one window."""
        return Windows(np.array([s.start for s in slices], dtype=np.intp), np.array([s.stop - s.start for s in slices]))

    @staticmethod
    def tiled(slices: Sequence[slice], length: int) -> Windows:
        """Windows of `length` cells, one after the other within each slice."""
        first = [np.arange(s.start, s.stop - length + 1, length) for s in slices]
        joined = np.concatenate(first) if first else np.empty(0)
        return Windows(joined.astype(np.intp), np.full(joined.size, length, dtype=np.intp))

    @property
    def length(self) -> int:
        """Cells of the longest."""
        return int(self.steps.max(initial=0))

    @property
    def index(self) -> NDArray[np.intp]:
        """(length, w) the cell of each step; a window that has ended stays in its last."""
        return np.asarray(self.first + np.minimum(np.arange(self.length)[:, None], self.steps - 1))

    def take(self, which: NDArray[np.bool_] | NDArray[np.intp]) -> Windows:
        return Windows(self.first[which], self.steps[which])


@dataclass(frozen=True, slots=True)
class MotionModel:
    """The part of a model that a simulation needs.

    Attributes:
        drag: d(r) [N m].
        inertia: I₀, as declared [kg m²].
        parts: the effects.
        offset: by how much the torque acts later than it is stamped [s].
    """

    drag: EvenTable
    inertia: float
    parts: tuple[Part, ...]
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Simulated windows: (length + 1, w) each; the water's rate by its time constant."""

    rate: Array
    heading: Array
    water: Mapping[float, Array]


@dataclass(frozen=True, slots=True)
class Instant:
    """The signals that effects of the motion may read, (m,) each, as of `Signals`."""

    rate: Array
    damping: Array
    heading: Array
    applied: Array
    water: Mapping[float, Array]
    drag_at: Callable[[Array], Array]
    drag_slope: Callable[[float], float]
    channels: Mapping[str, Array]
    acceleration: Array

    def lowpass(self, values: Array, time_constant: float) -> Array:
        """The water's rate: the only signal that an effect filters while it moves."""
        return self.water[time_constant]


class Dynamics:
    """A model over cells: everything that is known before the motion is simulated."""

    def __init__(self, cells: Cells, model: MotionModel) -> None:
        self.cells, self.model = cells, model
        s = cells.signals
        self.step, self.drag = cells.step, model.drag
        self.limit = -model.drag.first
        self.nudge = RATE_NUDGE_SHARE * self.limit / MAX_RATE_FACTOR
        self.inertia = model.inertia + sum(p.term.coefficients[0] for p in model.parts if p.effect.acts == "inertia")
        self.thrust, self.thrust_slope = self._thrust()
        self.seen = replace(
            s, applied=self.thrust, damping=model.drag(s.rate), acceleration=np.ones(len(s)), drag=model.drag
        )
        self.drive, self.factor = self.thrust, np.ones(len(s))
        self.motions, self.friction = list[Part](), list[Part]()
        for part in model.parts:
            if part.effect.acts == "outside":
                self.drive = self.drive - torque_taken(part, self.seen)
            elif part.effect.acts == "damping":
                self.factor = self.factor * part.effect.factor(self.seen, part.term)
            elif part.effect.acts == "motion":
                (self.friction if part.effect.dry_friction else self.motions).append(part)
        self.channels = {name for part in self.motions for name in part.effect.channels}

    def _thrust(self) -> tuple[Array, Array]:
        """(n,) the mean thrust of each cell [N m], and how it falls with each second that it is later [N m/s]."""
        cells, moment = self.cells, self.cells.fine.torque
        chain = sorted((p for p in self.model.parts if p.effect.acts == "thrust"), key=lambda p: p.effect.stage)
        for part in chain:
            moment = part.effect.thrust(moment, cells.fine, part.term)

        def mean(values: Array) -> Array:
            return np.asarray(values.reshape(-1, cells.parts).mean(axis=1))

        fine, offset = cells.fine, self.model.offset
        late, early = (mean(fine.later(moment, -offset - side * fine.step)) for side in (0.5, -0.5))
        return mean(fine.later(moment, -offset) if offset else moment), (early - late) / fine.step

    @property
    def constants(self) -> tuple[float, ...]:
        """Time constants of the water [s]."""
        return tuple(p.term.inner[-1] for p in self.motions if p.effect.name == "memory")

    def drag_slope(self, usual: float) -> float:
        """Mean slope of d between ± a usual rate [N m s]; positive, as drag is."""
        low, high = self.drag(np.array([-usual, usual]))
        return max(float(high - low) / (2.0 * usual), MIN_SLOPE)

    def instant(
        self, cell: NDArray[np.intp], rate: Array, heading: Array, water: Mapping[float, Array], channels: set[str]
    ) -> Instant:
        """The signals for effects of the motion in cells (m,), at rates and headings (m,)."""
        read = {name: self.cells.signals.channels[name][cell] for name in channels}
        return Instant(
            rate, self.drag(rate), heading, self.thrust[cell], water, self.drag, self.drag_slope, read, rate
        )  # fmt: skip

    def acceleration(
        self, cell: NDArray[np.intp], rate: Array, heading: Array, water: Mapping[float, Array], friction: bool
    ) -> Array:
        """(m,) ṙ [rad/s²] in cells (m,) at these rates, with dry friction only if asked for."""
        moment = self.drive[cell] - self.factor[cell] * self.drag(rate)
        parts = [*self.motions, *self.friction] if friction else self.motions
        return self._left_by(parts, moment, cell, rate, heading, water) / self.inertia

    def moment(self, cell: NDArray[np.intp], rate: Array, heading: Array, water: Mapping[float, Array]) -> Array:
        """(m,) what drives against inertia and damping [N m] in cells (m,) at these rates, but for dry friction."""
        return self._left_by(self.motions, self.drive[cell], cell, rate, heading, water)

    def _left_by(
        self,
        parts: Sequence[Part],
        moment: Array,
        cell: NDArray[np.intp],
        rate: Array,
        heading: Array,
        water: Mapping[float, Array],
    ) -> Array:
        """(m,) what these effects of the motion leave of a moment (m,) [N m]."""
        if parts:
            now = self.instant(cell, rate, heading, water, self.channels)
            for part in parts:
                moment = moment - torque_taken(part, now)
        return moment

    def simulate(self, windows: Windows) -> Trajectory:
        """The motion in each window from what was measured at its beginning."""
        s, h, index = self.cells.signals, self.step, windows.index
        rate, heading = s.rate[windows.first], s.heading[windows.first]
        water = {constant: s.lowpass(s.rate, constant)[windows.first] for constant in self.constants}
        shape = (windows.length + 1, rate.size)
        course = Trajectory(np.empty(shape), np.empty(shape), {constant: np.empty(shape) for constant in water})
        rubbed = self.friction_loss(0.5 * h)
        for k in range(windows.length + 1):
            course.rate[k], course.heading[k] = rate, heading
            for constant, values in water.items():
                course.water[constant][k] = values
            if k == windows.length:
                break
            before = rate
            if rubbed is not None:
                rate = coulomb_half_step(rate, *rubbed)
            rate = self._stepped(index[k], rate, heading, water)
            if rubbed is not None:
                rate = coulomb_half_step(rate, *rubbed)
            mean = 0.5 * (before + rate)
            heading = heading + h * mean
            water = {c: water_after(values, mean, h, c) for c, values in water.items()}
        return course

    def _stepped(self, cell: NDArray[np.intp], rate: Array, heading: Array, water: Mapping[float, Array]) -> Array:
        """(w,) the rates a cell later, but for dry friction."""
        both = np.concatenate([rate, rate + self.nudge])
        flowing = {constant: _twice(values) for constant, values in water.items()}
        push, there = self.acceleration(_twice(cell), both, _twice(heading), flowing, False).reshape(2, -1)
        z = np.minimum(self.step / self.nudge * (there - push), MAX_EXPONENT)
        z = np.where(np.abs(z) < MIN_EXPONENT, MIN_EXPONENT, z)
        new = rate + self.step * np.expm1(z) / z * push
        return np.asarray(np.clip(new, -self.limit, self.limit))

    def friction_loss(self, duration: float) -> tuple[Array, float] | None:
        """The loss of rate by dry friction in a while [rad/s], forward and backward, and its width [rad/s]."""
        if not self.friction:
            return None
        term = self.friction[0].term
        loss = np.maximum([term.coefficients[0], term.coefficients[-1]], 0.0) * duration / self.inertia
        return loss, term.inner[-1]


def water_after(water: Array, rate: Array, step: float, constant: float) -> Array:
    """The water's rate a step later, in which the vehicle turned at `rate` in the mean."""
    keep = float(np.exp(-step / constant))
    return keep * water + (1.0 - keep) * rate


def coulomb_half_step(rate: Array, loss: Array, width: float) -> Array:
    """Dry friction for a while, exactly: it slows the turn, ends it, and never turns the vehicle."""
    loss = np.where(rate > 0.0, loss[0], loss[1])
    rubbed: Array = np.sign(rate) * np.maximum(np.abs(rate) - loss * np.tanh(np.abs(rate) / width), 0.0)
    return rubbed


def torque_taken(part: Part, seen: Signals | Instant) -> Array:
    """(m,) what an effect takes of the torque [N m]."""
    columns = part.effect.columns(cast(Signals, seen), part.term.inner, part.term.coefficients)
    return np.asarray(columns @ part.term.coefficients)


def drag_table(function: Callable[[Array], Array], limit: float) -> EvenTable:
    """d(r) [N m] as a table over rates within ± limit [rad/s]."""
    even = np.linspace(-limit, limit, 2 * DRAG_TABLE_CELLS + 1)
    return EvenTable(-limit, limit / DRAG_TABLE_CELLS, function(even))


def _twice(values: Array | NDArray[np.intp]) -> NDArray:  # type: ignore[type-arg]
    return np.concatenate([values, values])
