"""The scan for what no effect explains: does any channel, time or heading still predict the residual?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.effects import SmoothTerm
from incsvr.plant.axes import YAW
from incsvr.tracing.findings import Unexplained
from incsvr.tracing.statistics import p_value
from incsvr.tracing.weak.evidence import evidence
from incsvr.tracing.weak.hypothesis import Hypothesis
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import LEAST_GAIN, FreeRun
from incsvr.tracing.weak.scan import scan, with_lead

LEVEL = 1e-3
"""Largest p-value, corrected for the number of terms tried."""

CONTRIBUTION = 0.05
"""Least deviation of what a term alone explains, in deviations of the block residual."""

SHAPE = 0.06
"""Of the largest effect's contribution: the catalogue knows no effect's true shape more closely than that, and any
channel may happen to follow what is left of it."""


def smooth_terms(
    problem: Problem, hypothesis: Hypothesis, channels: Sequence[str], free_run: FreeRun
) -> tuple[Hypothesis, tuple[Unexplained, ...]]:
    """`hypothesis` with smooth terms of what still predicts its residual, and their names."""
    found: list[Unexplained] = []
    # under one sine the heading is a function of the command's phase: what is left there is the shape of an effect
    by_heading = not problem.one_sine and problem.signals.rate_name == YAW.rate
    clock = ["time"] if problem.signals.one_clock else []
    tried = [*channels, *clock, *(["heading"] if by_heading else [])]
    for _ in range(3):
        taken = {term.effect for term in hypothesis.terms}
        terms = [SmoothTerm(name) for name in tried if f"unexplained:{name}" not in taken]
        leads = [lead for lead in scan(problem, hypothesis, terms) if lead.score > 0.0]
        if not leads:
            break
        grown = with_lead(problem, hypothesis, leads[0])
        last = len(grown.terms) - 1
        p = p_value(evidence(problem, grown, last), grown.effects[last].core, len(tried))
        others = max((_contribution(grown, k) for k in range(last)), default=0.0)
        large = _contribution(grown, last) > max(CONTRIBUTION, SHAPE * others)
        if not (
            free_run.better(grown, hypothesis)
            and large
            and p < LEVEL
            and grown.criterion > hypothesis.criterion + LEAST_GAIN
        ):
            break
        hypothesis = grown
        found.append(Unexplained(leads[0].effect.name.split(":", 1)[1], p))
    return hypothesis, tuple(found)


def _contribution(hypothesis: Hypothesis, k: int) -> float:
    """Deviation of what the k-th effect alone explains, in (robust) deviations of the block residual."""
    core = hypothesis.position[k] + np.arange(hypothesis.effects[k].core)
    rest = np.delete(hypothesis.columns, core, axis=1)
    part = hypothesis.columns[:, core] @ hypothesis.fit.theta[core] + hypothesis.offsets[k]
    residual = hypothesis.fit.residual
    alone = part - rest @ np.linalg.lstsq(rest, part, rcond=1e-10)[0]
    deviation = min(1.4826 * float(np.median(np.abs(residual - np.median(residual)))), float(np.std(residual)))
    return float(np.std(alone)) / max(deviation, 1e-300)
