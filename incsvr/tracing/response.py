"""The response of simulated windows to small changes of a hypothesis: the variational equation along the trajectory.

    s' = ∂f/∂r s + ∂f/∂ψ η + ∂f/∂m μ + ∂f/∂θ,    η' = s,    T μ' = s − μ

Nothing is simulated twice: of each free number the change of the acceleration is taken along the trajectory as it is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from incsvr.effects import Signals
from incsvr.numerics import Array
from incsvr.tracing.dynamics import Dynamics, Instant, Trajectory, Windows, torque_taken, water_after
from incsvr.tracing.hypothesis import Hypothesis, Part

HEADING_EFFECTS = ("heading_current", "tether", "unexplained:heading")
"""Effects that look at the heading."""
MAX_DECAY = 50.0
"""Exponent of one step by which a change decays at most."""
MAX_GROWTH = 5.0
"""Exponent of one step by which a change grows at most."""
MIN_EXPONENT = 1e-6
"""Exponent of one step at least: below, eᶻ − 1 has lost its digits."""
HEADING_NUDGE_RAD = 1e-4
"""Turn over which the slope with the heading is taken [rad]."""
RELATIVE_NUDGE = 1e-3
"""Part of a free number over which a slope is taken."""
MIN_NUDGE = 1e-6
"""Change of a free number over which a slope is taken, at least."""


class Response:
    """Windows with their trajectory, linearised."""

    def __init__(self, dynamics: Dynamics, windows: Windows, course: Trajectory) -> None:
        self.dynamics, self.windows = dynamics, windows
        index = windows.index
        self.shape, self.cell = index.shape, index.ravel()
        self.rate, self.heading = (_middle(values).ravel() for values in (course.rate, course.heading))
        self.water = {constant: _middle(values).ravel() for constant, values in course.water.items()}
        self.rise = (np.diff(course.rate, axis=0) / dynamics.step).ravel()
        base, nudge = self._at(self.rate, self.heading, self.water), dynamics.nudge
        slope = (self._at(self.rate + nudge, self.heading, self.water) - base) / nudge
        z = np.clip(dynamics.step * slope, -MAX_DECAY, MAX_GROWTH).reshape(self.shape)
        z = np.where(np.abs(z) < MIN_EXPONENT, MIN_EXPONENT, z)
        self.keep, self.gain = np.exp(z), dynamics.step * np.expm1(z) / z
        self.by_heading: Array | None = None
        if any(part.name in HEADING_EFFECTS for part in dynamics.motions):
            turned = self._at(self.rate, self.heading + HEADING_NUDGE_RAD, self.water)
            self.by_heading = ((turned - base) / HEADING_NUDGE_RAD).reshape(self.shape)
        self.by_water = {}
        for constant, values in self.water.items():
            moved = self._at(self.rate, self.heading, {**self.water, constant: values + nudge})
            self.by_water[constant] = ((moved - base) / nudge).reshape(self.shape)

    def _at(self, rate: Array, heading: Array, water: dict[float, Array]) -> Array:
        return self.dynamics.acceleration(self.cell, rate, heading, water, True)

    def of(self, pushes: Array) -> Array:
        """(p, length, w) change of the rate at the end of each step for pushes (p, length, w) [rad/s²] in each step."""
        step, out = self.dynamics.step, np.empty_like(pushes)
        change = np.zeros((pushes.shape[0], self.shape[1]))
        heading = np.zeros_like(change)
        water = {constant: np.zeros_like(change) for constant in self.by_water}
        for k in range(self.shape[0]):
            push = pushes[:, k]
            if self.by_heading is not None:
                push = push + self.by_heading[k] * heading
            for constant, slope in self.by_water.items():
                push = push + slope[k] * water[constant]
            new = self.keep[k] * change + self.gain[k] * push
            if self.by_heading is not None:
                heading = heading + 0.5 * step * (change + new)
            water = {c: water_after(values, 0.5 * (change + new), step, c) for c, values in water.items()}
            out[:, k] = change = new
        return out

    def push(self, part: Part, before: Part | None = None) -> Array:
        """(length·w,) change of the acceleration from the model with `before`, or without, to that with `part`."""
        effect, d = part.effect, self.dynamics
        if effect.acts == "inertia":
            old = before.term.coefficients[0] if before else 0.0
            return -self.rise * ((part.term.coefficients[0] - old) / d.inertia)
        if effect.acts == "thrust":
            others = tuple(each for each in d.model.parts if each is not before)
            moved = Dynamics(d.cells, replace(d.model, parts=(*others, part)))
            return np.asarray((moved.thrust - d.thrust)[self.cell] / d.inertia)
        if effect.acts == "damping":
            factor = before.effect.factor(d.seen, before.term) if before else np.ones(len(d.seen))
            change = d.factor / factor * (effect.factor(d.seen, part.term) - factor)
            return np.asarray(-change[self.cell] * d.drag(self.rate) / d.inertia)
        if effect.acts == "outside":
            moment = torque_taken(part, d.seen) - (torque_taken(before, d.seen) if before else 0.0)
            return np.asarray(-moment[self.cell] / d.inertia)
        now = self._instant(part, before)
        return np.asarray((torque_taken(before, now) if before else 0.0) - torque_taken(part, now)) / d.inertia

    def _instant(self, part: Part, before: Part | None) -> Instant:
        """The signals that the effect reads along the trajectory."""
        water = dict(self.water)
        if part.effect.name == "memory":
            for each in (part, before):
                if each is not None and each.term.inner[-1] not in water:
                    water[each.term.inner[-1]] = self._flow(each.term.inner[-1])
        now = self.dynamics.instant(self.cell, self.rate, self.heading, water, set(part.effect.channels))
        return replace(now, acceleration=self.rise)

    def _flow(self, constant: float) -> Array:
        """(length·w,) the water's rate along the trajectory, with another time constant than the model's."""
        s, step = self.dynamics.cells.signals, self.dynamics.step
        water, rate = s.lowpass(s.rate, constant)[self.windows.first], self.rate.reshape(self.shape)
        out = np.empty(self.shape)
        for k in range(self.shape[0]):
            new = water_after(water, rate[k], step, constant)
            out[k], water = 0.5 * (water + new), new
        return out.ravel()

    def slopes(self, part: Part) -> list[Array]:
        """Pushes (length·w,) for a change by one of each free number of a part of the model."""
        effect, d, found = part.effect, self.dynamics, list[Array]()
        if part.fixed:
            return []
        if effect.acts == "inertia":
            return [-self.rise / d.inertia]
        if effect.acts in ("outside", "motion") and not effect.curved:  # linear in the coefficients
            seen = d.seen if effect.acts == "outside" else self._instant(part, None)
            columns = effect.columns(cast(Signals, seen), part.term.inner, part.term.coefficients)
            columns = columns[self.cell] if effect.acts == "outside" else columns
            found = [-column / d.inertia for column in columns.T]
        vector = part.vector
        for k in range(len(found), vector.size):
            nudge = effect.nudge(d.cells.signals, k) or max(RELATIVE_NUDGE * abs(float(vector[k])), MIN_NUDGE)
            moved = vector.copy()
            moved[k] += nudge
            found.append(self.push(part.moved(moved), part) / nudge)
        return found

    def jacobian(self, hypothesis: Hypothesis) -> Array:
        """(p, length, w) change of the simulated rates with each free number of the hypothesis that was simulated."""
        d = self.dynamics
        factor = -d.factor[self.cell] / d.inertia
        rows = [factor * column for column in hypothesis.basis.columns(self.rate)]
        slope = -d.thrust_slope[self.cell] / d.inertia
        rows.append(slope if "torque_delay" not in hypothesis.names else np.zeros_like(slope))
        for part in hypothesis.parts:
            rows += self.slopes(part)
        return self.of(np.stack(rows).reshape(len(rows), *self.shape))


def _middle(values: Array) -> Array:
    """(length, w) means of neighbouring rows."""
    return 0.5 * (values[1:] + values[:-1])
