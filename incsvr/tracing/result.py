"""What a search by the forward form found, as the result that everybody reads."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from incsvr.evidence import p_value
from incsvr.tracer.findings import Finding, Pictures, Rejected, Trace
from incsvr.tracer.sentences import sentence, streams
from incsvr.tracing.candidates import starts
from incsvr.tracing.confidence import intervals
from incsvr.tracing.equations import predicted
from incsvr.tracing.fit import fit
from incsvr.tracing.grid import Grid
from incsvr.tracing.search import Found, Question
from incsvr.tracing.validation import model_of, residual, validate

Array = NDArray[np.float64]


def result_of(asked: Question, found: Found, unseen: Grid | None, ignored: Mapping[str, str]) -> Trace:
    """The findings with their errors on unseen data."""
    grid, best = asked.grid, found.best
    validation = validate(grid, best.parts, best, found.base, unseen)
    s = grid.signals
    depends = {"yaw_rate": s.rate, "torque": s.torque, "heading": s.heading, "time": s.time, **s.channels}
    declared, model = model_of(grid, found.base), model_of(grid, best)
    size = max(round(model.block / grid.cell), 1)
    error, change = validation.to_dict(model.sigma)
    return Trace(
        inertia=s.inertia,
        verdict="effects" if best.parts else "none",
        effects=tuple(_findings(asked, found)),
        rejected=tuple(_rejected(asked, found)),
        unexplained=(),
        error=error,
        ignored_channels=dict(ignored),
        notes=(),
        loop="closed",
        proven=bool(best.parts) and change.high < 0.0,
        declared_model=declared,
        model=model,
        pictures=Pictures(
            before=validation.before,
            after=validation.after,
            ledger_time=s.time,
            ledger=model.parts(predicted(grid, best.model).signals),
            residual_before=_means(residual(grid, found.base), size),
            residual_after=_means(residual(grid, best), size),
            depends={name: _means(values, size) for name, values in depends.items()},
        ),
    )


def _means(values: Array, size: int) -> Array:
    """Means of (n,) values over blocks of so many cells; what is left at the end is in none."""
    count = values.size // size
    return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))


def _findings(asked: Question, found: Found) -> list[Finding]:
    grid, best = asked.grid, found.best
    spans = intervals(grid, best)
    candidates = len({effect.name for effect in asked.effects})
    parts = best.parts
    squares = [float(np.mean(fit(grid, parts[:k], found.base).innovation ** 2)) for k in range(len(parts))]
    squares.append(float(np.mean(best.innovation**2)))
    total = max(squares[0] - squares[-1], 1e-300)
    findings = []
    for k, part in enumerate(parts):
        parameters = part.effect.parameters(part.term, grid.signals.inertia)
        share = float(np.clip((squares[k] - squares[k + 1]) / total, 0.0, 1.0))
        linear = 0 if part.thrust else len(part.term.coefficients)
        looks = candidates * sum(1 for _ in starts(part.effect, predicted(grid, best.model).signals))
        gain = found.gains[k] + asked.price(part)
        findings.append(
            Finding(
                effect=part.name,
                channels=streams(part.effect),
                parameters=parameters,
                interval=spans[k],
                p_value=p_value(gain, linear + int(part.searched), looks),
                share=share,
                cannot_tell_from=found.rivals[k],
                next_manoeuvre=_manoeuvre(grid, found.rivals[k]),
                sentence=sentence(part.effect, parameters, spans[k], share),
            )
        )
    return findings


def _manoeuvre(grid: Grid, rivals: tuple[str, ...]) -> str:
    if not rivals:
        return ""
    s = grid.signals
    top, hold = float(np.max(np.abs(s.torque))), max(4.0 * s.scale, 5.0)
    return (
        f"to tell it from {rivals[0]}, drive without the controller: steps of 25, 50, 75 and 100 % of {top:.3g} N m "
        f"both ways with rests, {hold:.3g} s each"
    )


def _rejected(asked: Question, found: Found) -> list[Rejected]:
    """What was looked at and not added, the most telling first."""
    named, out = set(found.best.names()), list[Rejected]()
    for lead in found.leads:
        name = lead.part.name
        if name in named or name in {rejected.effect for rejected in out}:
            continue
        gain = lead.gain + asked.price(lead.part)
        linear = 1 if lead.part.thrust else lead.part.effect.core
        p = p_value(gain, linear, len({effect.name for effect in asked.effects}) * lead.part.effect.looks)
        out.append(Rejected(name, p, found.refused.get(name, "beside what was found it brings too little")))
    return sorted(out, key=lambda rejected: rejected.p_value)
