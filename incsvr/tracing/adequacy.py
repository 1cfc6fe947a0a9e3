"""Whether what is left is one stationary disturbance that nothing recorded still predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.effects import SmoothTerm
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from incsvr.tracing import local_gain
from incsvr.tracing.candidates import leads
from incsvr.tracing.errors import Problem
from incsvr.tracing.findings import UnexplainedChannel
from incsvr.tracing.fit import Fit
from incsvr.tracing.search import FittedHypothesis, Search
from incsvr.tracing.spells import sentence, spans, spells
from incsvr.tracing.statistics import p_value, whitened
from incsvr.tracing.thresholds import MAX_SMOOTH_TERMS, SMOOTH_LEADS


def smooth_terms(
    search: Search, best: FittedHypothesis, channels: Sequence[str]
) -> tuple[FittedHypothesis, tuple[UnexplainedChannel, ...]]:
    """`best` with smooth terms of what still predicts its residual, and their names."""
    s = search.problem.cells.signals
    names = [*channels, *(["time"] if s.one_clock else []), *(["heading"] if s.rate_name == YAW.rate else [])]
    effects = [SmoothTerm(name) for name in names]
    found = list[UnexplainedChannel]()
    while len(found) < MAX_SMOOTH_TERMS:
        tried = []
        for lead in leads(search.problem, best.fitted, effects, SMOOTH_LEADS, 0):
            grown = search.tried(best.hypothesis.with_part(lead.part), best.fitted)
            if not search.why_not(grown, best):
                tried.append((search.better(grown, best).total, grown))
        if not tried:
            break
        gain, best = max(tried, key=lambda each: each[0])
        part = best.hypothesis.parts[-1]
        p = p_value(2.0 * gain / best.inflation, part.coefficients, len(names))
        found.append(UnexplainedChannel(part.name.split(":", 1)[1], p))
    return best, tuple(found)


@dataclass(frozen=True, slots=True)
class Unevenness:
    """Spans [s] in which the residual is larger, or the thrust's gain another, than elsewhere, with a sentence each."""

    spans: tuple[tuple[float, float], ...]
    notes: tuple[str, ...]


def unevenness(problem: Problem, fitted: Fit, residual: Array) -> Unevenness:
    """Spells of a fit's residual (n,) [N m] over the cells."""
    cells = problem.cells
    s = cells.signals
    white = whitened(residual, cells.start)
    moves = np.column_stack([np.gradient(s.torque), np.gradient(s.rate)])
    per_scale = s.scale / cells.step
    loud = spans(s.time, spells(white, moves, per_scale), cells.step)
    notes = [sentence(loud)] if loud else []
    other: tuple[tuple[float, float], ...] = ()
    if not problem.of_innovations:  # where a controller answers, the gain says nothing
        thrust = whitened(fitted.response.dynamics.thrust, cells.start, residual)
        other = spans(s.time, local_gain.uneven_gain(white, thrust, per_scale), cells.step)
        notes += [local_gain.sentence(other)] if other else []
    return Unevenness((*loud, *other), tuple(notes))
