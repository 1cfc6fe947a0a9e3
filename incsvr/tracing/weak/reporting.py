"""What was found in the weak form, and what was not added: findings with their evidence, in words."""

from __future__ import annotations

import numpy as np

from incsvr.tracing.findings import Finding, Rejected
from incsvr.tracing.run import Array
from incsvr.tracing.sentences import sentence, streams
from incsvr.tracing.statistics import p_value
from incsvr.tracing.weak.acceptance import forbidden
from incsvr.tracing.weak.evidence import intervals
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, nothing, settle
from incsvr.tracing.weak.manoeuvre import separate
from incsvr.tracing.weak.pipeline import Case, Indistinguishable, p_value_of
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import LEAST_GAIN
from incsvr.tracing.weak.scan import Lead, scan, with_lead


def findings_of(
    case: Case, base: Hypothesis, found: Hypothesis, complete: Hypothesis, alternatives: Indistinguishable
) -> tuple[list[Finding], list[str]]:
    """The findings, and notes on them: `found` beside the `base` without effects, `complete` with smooth terms, and
    what explains as much as each effect."""
    problem = case.problem
    spans = intervals(problem, found)
    notes: list[str] = []
    findings: list[Finding] = []
    last = _mean_square(base.fit.residual)
    total = max(last - _mean_square(complete.fit.residual), 1e-300)
    for k, (effect, term) in enumerate(zip(found.effects, found.terms, strict=True)):
        now = _mean_square(_first(problem, found, k + 1))
        explained_part = float(np.clip((last - now) / total, 0.0, 1.0))
        last = now
        parameters = effect.parameters(term, problem.signals.inertia)
        if below_sampling(term, problem):
            notes.append(
                f"torque and yaw rate are aligned by {next(iter(parameters.values())):.3g} s, less than a sample "
                "period: part of the sampling, not an effect"
            )
            continue
        p = p_value_of(case, found, k)
        tied = tuple(alternative.terms[-1].effect for alternative in alternatives[k])
        findings.append(
            Finding(
                effect=term.effect,
                channels=streams(effect),
                parameters=parameters,
                interval=spans[k],
                p_value=p,
                share=explained_part,
                cannot_tell_from=tied,
                next_manoeuvre=separate(problem, found, alternatives[k][0], tied[0]) if tied else "",
                sentence=sentence(effect, parameters, spans[k], explained_part),
            )
        )
    if {"tether", "bias_torque"} <= set(found.names()):
        notes.append("a constant moment beside a tether is, in the equation, a tether untwisted at another heading")
    return findings, notes


def rejected_of(case: Case, found: Hypothesis, failed: dict[str, str]) -> list[Rejected]:
    """What the search refused, and every other candidate with the evidence that is left for it, most telling first."""
    taken = set(found.names()) | set(failed)
    rejected: list[Rejected] = []
    for lead in scan(case.problem, found, case.effects):
        p = p_value(lead.gain, lead.effect.core, lead.effect.looks)
        if lead.effect.name in failed and lead.effect.name not in {r.effect for r in rejected}:
            rejected.append(Rejected(lead.effect.name, p, failed[lead.effect.name]))
        elif lead.effect.name not in taken:
            taken.add(lead.effect.name)
            rejected.append(Rejected(lead.effect.name, p, _why_not(case.problem, found, lead)))
    return sorted(rejected, key=lambda r: r.p_value)


def _why_not(problem: Problem, found: Hypothesis, lead: Lead) -> str:
    """Why a candidate that no gate ever saw is not added."""
    if lead.score < LEAST_GAIN:
        return "too little evidence beside what was found"
    reason, k = forbidden(problem, with_lead(problem, found, lead))
    return reason if reason and k == len(found.terms) else "beside what was found it brings too little"


def _first(problem: Problem, found: Hypothesis, count: int) -> Array:
    """Residual with the first `count` effects alone."""
    if count == len(found.terms):
        return found.fit.residual
    return settle(problem, found.values()[:count], nothing(problem)).fit.residual


def _mean_square(residual: Array) -> float:
    """Robust against outliers: of the residual drawn in to four deviations."""
    limit = 4.0 * 1.4826 * float(np.median(np.abs(residual)))
    return float(np.mean(np.clip(residual, -limit, limit) ** 2))
