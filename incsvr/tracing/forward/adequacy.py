"""Whether what is left is still told by a channel, by time or by heading, though no effect of the catalogue fits."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.effects import SmoothTerm
from incsvr.plant.axes import YAW
from incsvr.tracing.findings import Unexplained
from incsvr.tracing.forward.equations import predicted
from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.search import gain_of, is_relevant, required, scan, settled
from incsvr.tracing.statistics import p_value

MOST = 3
"""Smooth terms that are added."""

LEADS = 3
"""Of them fitted in full in each round."""


def smooth_terms(question: Question, found: Fit, channels: Sequence[str]) -> tuple[Fit, tuple[Unexplained, ...]]:
    """`found` with smooth terms of what still tells its residual, and their names."""
    s = question.grid.signals
    names = [*channels, *(["time"] if s.one_clock else []), *(["heading"] if s.rate_name == YAW.rate else [])]
    smooth_question = Question.of(question.grid, [SmoothTerm(name) for name in names], found)
    unexplained = list[Unexplained]()
    while len(unexplained) < MOST:
        leads = [lead for lead in scan(smooth_question, found) if lead.gain > 0.0][:LEADS]
        tried = [settled(question.grid, found, lead.part) for lead in leads]
        gains = [gain_of(smooth_question, fitted, len(fitted.parts) - 1) for fitted in tried]
        if not gains or max(gains) < required(found):
            break
        grown = tried[gains.index(max(gains))]
        part = grown.parts[-1]
        if not is_relevant(predicted(question.grid, grown.model).signals, part):
            break
        found = grown
        p = p_value(max(gains) + smooth_question.price(part), len(part.term.coefficients), len(names))
        unexplained.append(Unexplained(part.name.split(":", 1)[1], p))
    return found, tuple(unexplained)
