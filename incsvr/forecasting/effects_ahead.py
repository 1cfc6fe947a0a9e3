"""The torque of traced effects in parallel free runs, step by step, with the memory of the effects.

The rows and stages are the engine's; a moment falls with the rate by the same slopes as in its tangent.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation
from incsvr.forecasting.grid import Grid
from incsvr.model.efforts import Stage, lagged, means
from incsvr.model.factors import one_by_one, slopes
from incsvr.model.rows import Factor
from incsvr.model.series import effort_of
from incsvr.numerics import Array
from incsvr.tracing.model import stages

Term = tuple[float, Factor, Factor]
"""A number times two factors."""


class EffectsAhead:
    """The effects on the points of a grid without a pause.

    The thrust is worked out of the whole grid's torque, so that a lag goes on from what came before a run.
    """

    def __init__(self, effects: Compensation, grid: Grid) -> None:
        model, axis = effects.model, effects.model.axis
        self.added_inertia = model.whole_inertia - model.inertia
        """The difference of the inertia from the declared one [kg m²]."""
        edges = np.append(grid.time, grid.time[-1] + grid.step)
        stage = [Stage(), *(stage for _, stage in stages(model.effects, axis))][-1]
        self._axis, self._effort = axis, effort_of(axis)
        self._given = {self._effort: means((grid.time, grid.torque), edges, "linear", stage, model.top)}
        self._given |= {name: grid.beside.channels[stream] for name, stream in effects.streams.items() if name != axis}
        self._terms, self._slopes, self._constants = list[Term](), list[Term](), dict[str, float]()
        for effect in model.effects:
            for row in effect.rows:
                part, weight = row.parts[0], effect.theta[row.key] * row.parts[0].sign
                self._terms.append((weight, part.one, part.other))
                for one, other in ((part.one, part.other), (part.other, part.one)):
                    self._slopes += [(weight * n, slope, other) for n, slope, of in slopes(one) if of == axis]
                if row.follows:
                    self._constants[f"~{row.key}"] = effect.value("time", row.key) or grid.step
        self._first, self._turned = np.zeros(1, dtype=np.intp), np.zeros(1)
        self._water = {name: lagged(grid.rate, grid.step / constant) for name, constant in self._constants.items()}

    def runs(self, first: NDArray[np.intp]) -> EffectsAhead:
        """The effects along runs that begin at these points (n,) of the grid."""
        found = copy(self)
        found._first = first
        found._water = {name: water[first] for name, water in self._water.items()}
        found._turned = self._given[HEADING_CHANNEL][first] if HEADING_CHANNEL in self._given else np.zeros(first.size)
        return found

    def at(self, k: int, rate: Array, turned: Array) -> tuple[Array, Array]:
        """In step k, at the rates (n,) [rad/s] and turned so far (n,) [rad], (n,) each: the moment that drives [N m],
        and by how much it falls with the rate [N m s]."""
        cell = np.minimum(self._first + k, self._given[self._effort].size - 1)
        seen = {name: values[cell] for name, values in self._given.items()}
        seen |= {**self._water, self._axis: rate, HEADING_CHANNEL: self._turned + turned}
        taken, falls = (
            sum((weight * one_by_one(one, seen) * one_by_one(other, seen) for weight, one, other in terms), 0.0 * rate)
            for terms in (self._terms, self._slopes)
        )
        return seen[self._effort] - taken, falls

    def moved(self, rate: Array, step: float) -> None:
        """A step passed, in which the runs turned at these rates (n,) in the mean [rad/s]."""
        for name, constant in self._constants.items():
            kept = float(np.exp(-step / constant))
            self._water[name] = kept * self._water[name] + (1.0 - kept) * rate
