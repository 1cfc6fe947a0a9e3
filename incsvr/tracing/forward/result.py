"""What a search found, as the result that everybody reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.disturbance import disturbance
from incsvr.tracing.findings import Finding, Pictures, Rejected, Trace
from incsvr.tracing.forward.adequacy import smooth_terms
from incsvr.tracing.forward.confidence import intervals
from incsvr.tracing.forward.equations import columns, predicted
from incsvr.tracing.forward.equivalence import indistinguishable, separate
from incsvr.tracing.forward.fit import fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.refusals import remarks
from incsvr.tracing.forward.search import Found
from incsvr.tracing.forward.validation import model_of, residual, validate
from incsvr.tracing.sentences import of_clocks, sentence, streams
from incsvr.tracing.skill import proven
from incsvr.tracing.spells import sentence as sentence_of_spells
from incsvr.tracing.spells import spans, spells
from incsvr.tracing.statistics import p_value

Array = NDArray[np.float64]


def result_of(
    question: Question,
    found: Found,
    validation_grid: Grid | None,
    ignored: Mapping[str, str],
) -> Trace:
    """The findings with their errors on unseen data.

    Args:
        question: which recordings were asked for what.
        found: by the search.
        validation_grid: recordings for validation; without them pieces are held out.
        ignored: why some channels were no candidates.
    """
    grid = question.grid
    channels = [name for name in grid.signals.channels if name not in ignored]
    best, unexplained = smooth_terms(question, found.best, channels)
    validation = validate(grid, best, found.base, validation_grid)
    s = grid.signals
    depends = {"yaw_rate": s.rate, "torque": s.torque, "heading": s.heading, "time": s.time, **s.channels}
    declared, model = model_of(grid, found.base), model_of(grid, best)
    size = max(round(model.block / grid.cell), 1)
    moves = np.column_stack([np.gradient(s.torque), grid.rise])
    inside = spells(np.asarray(best.innovation), moves, s.scale / grid.cell)
    spell_spans = spans(s.time, inside, grid.cell)
    left = _means(residual(grid, best), size)
    error = validation.to_dict(model.sigma) | {"disturbance": disturbance(left, size * grid.cell, s.torque)}
    return Trace(
        inertia=s.inertia,
        verdict="effects" if found.best.parts else "unexplained" if unexplained or spell_spans else "none",
        effects=tuple(_findings(question, found)),
        rejected=tuple(_rejected(question, found)),
        unexplained=unexplained,
        error=error,
        ignored_channels=dict(ignored),
        notes=(*remarks(grid), *of_clocks(s), *([sentence_of_spells(spell_spans)] if spell_spans else [])),
        loop="closed",
        proven=bool(found.best.parts) and proven(error, closed_loop=True),
        spans=spell_spans,
        one_clock=s.one_clock,
        declared_model=declared,
        model=model,
        pictures=Pictures(
            before=validation.before,
            after=validation.after,
            ledger_time=s.time,
            ledger=model.parts(predicted(grid, best.model).signals),
            residual_before=_means(residual(grid, found.base), size),
            residual_after=left,
            depends={name: _means(values, size) for name, values in depends.items()},
        ),
    )


def _means(values: Array, size: int) -> Array:
    """Means of (n,) values over blocks of so many cells; what is left at the end is in none."""
    count = values.size // size
    return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))


def _findings(question: Question, found: Found) -> list[Finding]:
    grid, best = question.grid, found.best
    spans = intervals(grid, best)
    candidates = len({effect.name for effect in question.effects})
    parts = best.parts
    squares = [float(np.mean(fit(grid, parts[:k], found.base).innovation ** 2)) for k in range(len(parts))]
    squares.append(float(np.mean(best.innovation**2)))
    total = max(squares[0] - squares[-1], 1e-300)
    findings, model = [], model_of(grid, best)
    for k, part in enumerate(parts):
        parameters = part.effect.parameters(part.term, grid.signals.inertia)
        explained_part = float(np.clip((squares[k] - squares[k + 1]) / total, 0.0, 1.0))
        linear = 0 if part.thrust else len(part.term.coefficients)
        looks = candidates * part.effect.looks
        gain = found.gains[k] + question.price(part)
        others = indistinguishable(question, best, k)
        findings.append(
            Finding(
                effect=part.name,
                channels=streams(part.effect),
                parameters=parameters,
                interval=spans[k],
                p_value=p_value(gain, linear + int(part.searched), looks),
                share=explained_part,
                cannot_tell_from=tuple(other.parts[-1].name for other in others),
                next_manoeuvre=separate(grid, model, best, others[0]) if others else "",
                sentence=sentence(part.effect, parameters, spans[k], explained_part),
            )
        )
    return findings


def _rejected(question: Question, found: Found) -> list[Rejected]:
    """What was looked at and not added, the most telling first."""
    named, out = set(found.best.names()), list[Rejected]()
    s = replace(predicted(question.grid, found.best.model).signals, residual=found.best.innovation)
    for lead in found.leads:
        name = lead.part.name
        if name in named or name in {rejected.effect for rejected in out}:
            continue
        gain = lead.gain + question.price(lead.part)
        linear = 1 if lead.part.thrust else columns(lead.part, s).shape[0]
        p = p_value(gain, linear, len(question.effects) * lead.part.effect.looks)
        out.append(Rejected(name, p, found.refused.get(name, "beside what was found it brings too little")))
    return sorted(out, key=lambda rejected: rejected.p_value)
