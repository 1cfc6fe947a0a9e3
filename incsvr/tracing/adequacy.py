"""Whether what is left is one stationary disturbance that nothing recorded still predicts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.effects import SmoothTerm
from incsvr.model_trace.findings import UnexplainedChannel
from incsvr.model_trace.spells import spans, spells
from incsvr.model_trace.statistics import p_value, whitened
from incsvr.model_trace.thresholds import MAX_SMOOTH_TERMS, SMOOTH_LEADS
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from incsvr.tracing.candidates import leads
from incsvr.tracing.cells import Cells
from incsvr.tracing.search import FittedHypothesis, Search


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


def loud_spells(cells: Cells, residual: Array) -> tuple[tuple[float, float], ...]:
    """Spans [s] in which a residual (n,) [N m] over the cells is larger than elsewhere."""
    s = cells.signals
    moves = np.column_stack([np.gradient(s.torque), np.gradient(s.rate)])
    return spans(s.time, spells(whitened(residual, cells.start), moves, s.scale / cells.step), cells.step)
