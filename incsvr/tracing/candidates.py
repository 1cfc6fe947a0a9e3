"""What one more effect would explain beside a fit: every start of every candidate, in one step, alone and together with
a free inertia."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect, candidates
from incsvr.model_trace.thresholds import MAX_LEADING_FORMS, MIN_LEAD_GAIN, MIN_PAIR_GAIN, TIED_STEP_RANGE
from incsvr.numerics import Array
from incsvr.tracing.cells import Cells
from incsvr.tracing.dynamics import Dynamics, Windows
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, precision
from incsvr.tracing.hypothesis import Part, starts


def admissible(names: Sequence[str], cells: Cells) -> tuple[Effect, ...]:
    """The catalogue's effects for these channels; where the torque never changes, those that turn a vehicle without."""
    s = cells.signals
    every = candidates(names, s.rate_name, s.one_clock)
    if float(np.ptp(s.torque)) > 0.0:
        return every
    return tuple(e for e in every if e.acts == "outside" or e.name in ("heading_current", "tether"))


@dataclass(frozen=True, slots=True)
class Lead:
    """One candidate, or one and a free inertia, and by how much the log likelihood would rise in one step."""

    parts: tuple[Part, ...]
    gain: float

    @property
    def part(self) -> Part:
        return self.parts[0]

    @property
    def key(self) -> tuple[str, int]:
        return self.part.effect.key, len(self.parts)


def leads(problem: Problem, fitted: Fit, effects: Sequence[Effect], alone: int, pairs: int) -> list[Lead]:
    """The most telling candidates that are not in the fit: so many alone, so many with a free inertia."""
    found: dict[tuple[str, int], Lead] = {}
    for lead in every_lead(problem, fitted, effects):
        if lead.key not in found or lead.gain > found[lead.key].gain:
            found[lead.key] = lead
    singly = {key: lead.gain for (key, count), lead in found.items() if count == 1}
    chosen = list[Lead]()
    for lead in sorted(found.values(), key=lambda each: -each.gain):
        same = [each for each in chosen if len(each.parts) == len(lead.parts)]
        more = lead.gain - max(singly[part.effect.key] for part in lead.parts)
        if lead.gain < MIN_LEAD_GAIN or (len(lead.parts) > 1 and more < MIN_PAIR_GAIN):
            continue
        forms = sum(each.part.name == lead.part.name for each in same)
        if forms < MAX_LEADING_FORMS and len(same) < (alone if len(lead.parts) == 1 else pairs):
            chosen.append(lead)
    return chosen


def every_lead(problem: Problem, fitted: Fit, effects: Sequence[Effect]) -> Iterator[Lead]:
    """Every start of every candidate, alone and beside a free inertia."""
    dynamics = fitted.response.dynamics
    seen = replace(dynamics.seen, residual=residual(dynamics))
    begun = [p for e in effects if e.name not in fitted.hypothesis.names for p in starts(e, seen)]
    if not begun:
        return
    columns = [_columns(fitted, problem.cells, part) for part in begun]
    owner = np.repeat(np.arange(len(begun)), [len(each) for each in columns])
    pushes = np.concatenate(columns).reshape(owner.size, *fitted.response.shape)
    root = np.sqrt(fitted.weight)
    x = fitted.colour.whiten(problem.looked_at(fitted.response.of(pushes))) * root
    beside = _NormalEquations.of(problem, fitted, x.reshape(owner.size, -1))
    inertia = next((k for k, part in enumerate(begun) if part.effect.acts == "inertia"), None)
    wider, first = None, 0.0
    if inertia is not None:
        wider, first = beside.with_row(owner == inertia), beside.gain(owner == inertia, False)[0]
    for k, part in enumerate(begun):
        tied = part.effect.from_start or part.effect.fixed_coefficient
        gain, step = beside.gain(owner == k, tied)
        yield Lead((_moved(part, step, tied),), gain / fitted.variance)
        if wider is not None and inertia is not None and k != inertia:
            gain, step = wider.gain(owner == k, tied)
            yield Lead((_moved(part, step, tied), begun[inertia]), (gain + first) / fitted.variance)


def _columns(fitted: Fit, cells: Cells, part: Part) -> Array:
    """(c, n) pushes of a candidate: of its whole start where it is tied to it, else for each coefficient by one."""
    effect, vector, response = part.effect, part.vector, fitted.response
    if effect.from_start or effect.fixed_coefficient:
        return response.push(part)[None]
    rows = []
    for k in range(part.coefficients):
        size = effect.small(cells.signals, part.term)
        moved = np.concatenate([size * np.eye(part.coefficients)[k], vector[part.coefficients :]])
        rows.append(response.push(part.moved(moved)) / size)
    return np.stack(rows)


def _moved(part: Part, step: Array, tied: bool) -> Part:
    """The candidate where one step leads; of one that is tied to its start, there."""
    return part if tied else part.moved(np.concatenate([step, part.vector[step.size :]]))


def residual(dynamics: Dynamics) -> Array:
    """(n,) what a model lacks of the torque in each cell, predicted from the rate at its beginning [N m]."""
    cells = dynamics.cells
    every = Windows(np.arange(len(cells)), np.ones(len(cells), dtype=np.intp))
    return np.asarray((dynamics.simulate(every).rate[1] - cells.end) * (dynamics.inertia / cells.step))


@dataclass(frozen=True, slots=True)
class _NormalEquations:
    """Normal equations of a fit, and how the columns of candidates stand to them.

    Attributes:
        information: (p, p) of the fit.
        pull: (p,) its gradient.
        x: (m, n) columns of the candidates, whitened and weighed.
        cross: (p, m) of the fit's columns with these.
        slope: (m,) gradient along these.
    """

    information: Array
    pull: Array
    x: Array
    cross: Array
    slope: Array

    @staticmethod
    def of(problem: Problem, fitted: Fit, x: Array) -> _NormalEquations:
        """Beside the fit, its colour free as well."""
        root = np.sqrt(fitted.weight)
        base = (fitted.jacobian * root).reshape(fitted.jacobian.shape[0], -1)
        errors = (fitted.errors * root).ravel()
        prior = precision(problem, fitted.hypothesis, fitted.colour) * fitted.variance
        values = np.concatenate([fitted.hypothesis.vector, np.zeros(fitted.colour.vector.size)])
        return _NormalEquations(base @ base.T + prior, base @ errors + prior @ values, x, base @ x.T, x @ errors)

    def gain(self, which: NDArray[np.bool_], tied: bool) -> tuple[float, Array]:
        """The fall of half the weighted square by one step in some of the columns, and that step.

        A tied step is the whole of its column: a lag or a limit is at its start, not somewhere along a line to it.
        """
        cross, own = self.cross[:, which], self.x[which]
        solved = np.linalg.lstsq(self.information, np.column_stack([cross, self.pull]))[0]
        square = own @ own.T
        left = square - cross.T @ solved[:, :-1] + np.diag(1e-9 * np.diag(square) + 1e-300)
        slope = self.slope[which] - cross.T @ solved[:, -1]
        if tied:
            part = float(np.clip(-slope[0] / left[0, 0], *TIED_STEP_RANGE))
            return -part * float(slope[0] + 0.5 * part * left[0, 0]), np.ones(1)
        step = -np.linalg.lstsq(left, slope)[0]
        return -0.5 * float(slope @ step), np.asarray(step, dtype=np.float64)

    def with_row(self, row: NDArray[np.bool_]) -> _NormalEquations:
        """The equations beside one more column."""
        own, more = self.x[row], self.cross[:, row]
        information = np.block([[self.information, more], [more.T, own @ own.T]])
        pull, cross = np.concatenate([self.pull, self.slope[row]]), np.concatenate([self.cross, own @ self.x.T])
        return replace(self, information=information, pull=pull, cross=cross)
