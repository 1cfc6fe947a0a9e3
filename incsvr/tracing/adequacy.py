"""Whether what is left is one stationary disturbance that nothing recorded still predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import SmoothTerm
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from incsvr.tracing import local_gain
from incsvr.tracing.candidates import leads
from incsvr.tracing.errors import Problem
from incsvr.tracing.findings import Unexplained
from incsvr.tracing.fit import Fit
from incsvr.tracing.search import Search, Tried
from incsvr.tracing.spells import sentence, spans, spells
from incsvr.tracing.statistics import p_value

MAX_SMOOTH_TERMS, LEADS = 3, 3
"""Smooth terms that are added, and how many of them are fitted in each round."""


def smooth_terms(search: Search, best: Tried, channels: Sequence[str]) -> tuple[Tried, tuple[Unexplained, ...]]:
    """`best` with smooth terms of what still predicts its residual, and their names."""
    s = search.problem.cells.signals
    names = [*channels, *(["time"] if s.one_clock else []), *(["heading"] if s.rate_name == YAW.rate else [])]
    effects = [SmoothTerm(name) for name in names]
    found = list[Unexplained]()
    while len(found) < MAX_SMOOTH_TERMS:
        tried = []
        for lead in leads(search.problem, best.fitted, effects, LEADS, 0):
            grown = search.tried(best.hypothesis.with_part(lead.part), best.fitted)
            if not search.why_not(grown, best):
                tried.append((search.better(grown, best).total, grown))
        if not tried:
            break
        gain, best = max(tried, key=lambda each: each[0])
        part = best.hypothesis.parts[-1]
        p = p_value(2.0 * gain / best.inflation, part.coefficients, len(names))
        found.append(Unexplained(part.name.split(":", 1)[1], p))
    return best, tuple(found)


@dataclass(frozen=True, slots=True)
class Uneven:
    """Where what is left is louder, or the thrust's gain another, than elsewhere: spans [s], and a sentence each."""

    spans: tuple[tuple[float, float], ...]
    notes: tuple[str, ...]


def uneven(problem: Problem, fitted: Fit, residual: Array) -> Uneven:
    """Spells of a fit's residual (n,) [N m] over the cells."""
    cells = problem.cells
    s = cells.signals
    white = _whitened(residual, cells.start)
    moves = np.column_stack([np.gradient(s.torque), np.gradient(s.rate)])
    per_scale = s.scale / cells.step
    loud = spans(s.time, spells(white, moves, per_scale), cells.step)
    notes = [sentence(loud)] if loud else []
    other: tuple[tuple[float, float], ...] = ()
    if not problem.of_innovations:  # where a controller answers, the gain says nothing
        thrust = _whitened(fitted.response.dynamics.thrust, cells.start, residual)
        other = spans(s.time, local_gain.uneven(white, thrust, per_scale), cells.step)
        notes += [local_gain.sentence(other)] if other else []
    return Uneven((*loud, *other), tuple(notes))


PAST = 3
"""Past values that whiten the present one."""


def _whitened(values: Array, starts: NDArray[np.intp], by: Array | None = None) -> Array:
    """(n,) values through the autoregression that whitens `by`, or themselves; zero at the beginning of pieces."""
    by = values if by is None else by

    def past(of: Array) -> Array:
        return np.stack([np.roll(of, k) for k in range(1, PAST + 1)], axis=1)

    usable = np.ones(values.size, dtype=bool)
    for k in range(PAST):
        usable[np.minimum(starts[:-1] + k, values.size - 1)] = False
    theta = np.linalg.lstsq(past(by)[usable], by[usable])[0]
    return np.where(usable, values - past(values) @ theta, 0.0)
