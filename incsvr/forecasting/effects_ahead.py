"""The torque of traced effects in parallel free runs, step by step, with the memory of the effects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation
from incsvr.effects import Signals
from incsvr.forecasting.grid import Grid
from incsvr.numerics import Array
from incsvr.tracing.cells import plain
from incsvr.tracing.dynamics import Dynamics, coulomb_half_step, water_after
from incsvr.tracing.of_model import motion_of


class EffectsAhead:
    """The effects on the points of a grid without a pause.

    The thrust is worked out of the whole grid's torque, so that a lag goes on from what came before a run. The damping
    that an effect looks at is that of its trace.
    """

    def __init__(self, effects: Compensation, grid: Grid) -> None:
        model, count = effects.model, grid.time.size
        heading = grid.beside.channels.get(HEADING_CHANNEL)
        if heading is None:
            heading = grid.step * (np.cumsum(grid.rate) - grid.rate)
        mean = 0.5 * (grid.torque + np.append(grid.torque[1:], grid.torque[-1:]))
        signals = Signals(
            step=grid.step, start=np.array([0, count], dtype=np.intp), time=grid.time, rate=grid.rate, torque=mean,
            channels=grid.beside.channels, heading=heading, inertia=model.inertia, scale=model.scale,
            block=model.block, origin=model.origin,
        )  # fmt: skip
        self._dynamics, self._signals = Dynamics(plain(signals), motion_of(model)), signals
        self._water = {c: signals.lowpass(grid.rate, c) for c in self._dynamics.constants}
        self._loss = self._dynamics.friction_loss(0.5 * grid.step)

    @property
    def added_inertia(self) -> float:
        """The difference of the inertia from the declared one [kg m²]."""
        return self._dynamics.inertia - self._dynamics.model.inertia

    def runs(self, first: NDArray[np.intp]) -> EffectsOnRuns:
        """The effects on runs that begin at these points (n,) of the grid."""
        water = {constant: values[first] for constant, values in self._water.items()}
        return EffectsOnRuns(self._dynamics, first, self._signals.heading[first], water, self._loss)


class EffectsOnRuns:
    """The effects on n runs from `first` (n,) on, step by step, with the memory of the water."""

    def __init__(
        self,
        dynamics: Dynamics,
        first: NDArray[np.intp],
        heading: Array,
        water: dict[float, Array],
        loss: tuple[Array, float] | None,
    ) -> None:
        self._dynamics, self._first, self._heading, self._water, self._loss = dynamics, first, heading, water, loss
        self._cell = first

    def at(self, k: int, rate: Array, turned: Array) -> tuple[Array, Array, Array]:
        """In step k, at the rates (n,) [rad/s] and turned so far (n,) [rad], (n,) each: the moment that drives [N m],
        by how much it falls with the rate [N m s], and the factor on the damping."""
        dynamics = self._dynamics
        self._cell = np.minimum(self._first + k, len(dynamics.cells) - 1)
        heading, nudge = self._heading + turned, dynamics.nudge
        moment = dynamics.moment(self._cell, rate, heading, self._water)
        if not dynamics.motions:
            return moment, np.zeros(rate.size), dynamics.factor[self._cell]
        there = dynamics.moment(self._cell, rate + nudge, heading, self._water)
        return moment, (moment - there) / nudge, dynamics.factor[self._cell]

    def rubbed(self, rate: Array) -> Array:
        """(n,) the rates after half a step of dry friction."""
        return rate if self._loss is None else coulomb_half_step(rate, *self._loss)

    def moved(self, rate: Array, step: float) -> None:
        """A step passed, in which the runs turned at these rates (n,) in the mean [rad/s]."""
        self._water = {c: water_after(values, rate, step, c) for c, values in self._water.items()}
