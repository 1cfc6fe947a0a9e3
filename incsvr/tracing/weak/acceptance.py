"""The gates that every effect must pass: physics, relevance, evidence and the free run."""

from __future__ import annotations

import numpy as np

from incsvr.tracing.weak.evidence import evidence
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, views
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import STRONG, FreeRun, required_gain
from incsvr.tracing.weak.scan import without

PROVEN = 0.9
"""Free-run error, in parts of that without an effect, below which an effect that the noise's colour may pass for is
plainly there."""


def pays(problem: Problem, free_run: FreeRun, new: Hypothesis, old: Hypothesis) -> bool:
    """Whether the free run gets better: by more than chance, or at all where the equation leaves no doubt.

    Or where no thrust drove it: all that a free run then holds is the effect and the decay of the first rate.
    """
    decisive = new.criterion - old.criterion > STRONG or float(np.ptp(problem.signals.torque)) == 0.0
    return free_run.better(new, old) or (decisive and free_run(new) < free_run(old))


def objection(problem: Problem, free_run: FreeRun, base: Hypothesis) -> tuple[str, int]:
    """What speaks against one effect of a hypothesis, and which; empty if nothing does."""
    reason, k = forbidden(problem, base)
    if reason:
        return reason, k
    gains = [evidence(problem, base, j) for j in range(len(base.terms))]
    required = [required_gain(problem, base, j) for j in range(len(gains))]
    k = min(range(len(gains)), key=lambda j: gains[j] - required[j])
    if gains[k] < required[k]:
        return f"too little evidence for noise of this colour: 2 Δℓ is {gains[k]:.0f}, {required[k]:.0f} is asked", k
    for k, (effect, term) in enumerate(zip(base.effects, base.terms, strict=True)):
        reduced = without(problem, base, k)
        if effect.must_prove(term, problem.signals) and not free_run(base) < PROVEN * free_run(reduced):
            return "it is so short that the noise's colour may pass for it, and the free run is not plainly better", k
        if not pays(problem, free_run, base, reduced):
            return (
                "it improves the torque equation, but the free run on unseen data gets no better than chance would "
                f"have it: {free_run(reduced):.3g} rad/s without it, {free_run(base):.3g} rad/s with it"
            ), k
    return "", 0


def against_physics(problem: Problem, hypothesis: Hypothesis) -> tuple[str, int] | None:
    """Why physics forbids one of the effects, and which."""
    seen = views(problem, hypothesis)
    for k, (effect, term) in enumerate(zip(hypothesis.effects, hypothesis.terms, strict=True)):
        if not np.all(np.isfinite(term.coefficients)):
            return "no finite fit", k
        reason = effect.implausible(term, seen.of(effect))
        if reason:
            return reason, k
    values = {t.effect: t.coefficients[0] for t in hypothesis.terms if not below_sampling(t, problem)}
    if values.get("torque_delay", 0.0) < 0.0 < values.get("torque_lag", 0.0):
        return "a lag against a negative delay is no effect but a shape", hypothesis.names().index("torque_lag")
    return None


def forbidden(problem: Problem, hypothesis: Hypothesis) -> tuple[str, int]:
    """Why physics, or what was declared, forbids one of the effects, and which; an empty reason if neither does."""
    against = against_physics(problem, hypothesis)
    if against:
        return against
    seen = views(problem, hypothesis)
    for k, (effect, term) in enumerate(zip(hypothesis.effects, hypothesis.terms, strict=True)):
        slight = effect.slight(term, seen.of(effect))
        if slight:
            return slight, k
    return "", 0
