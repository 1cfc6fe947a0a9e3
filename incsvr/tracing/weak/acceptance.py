"""The gates that every effect must pass: physics, size, evidence, a residual that falls, and the free run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.tracing.weak.evidence import evidence, explained
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, nothing, views
from incsvr.tracing.weak.partial_contribution import PASSING, in_passing, lost_in_noise, rose
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import STRONG, FreeRun, required_gain
from incsvr.tracing.weak.scan import excepting, without

LOST = "what it alone explains is lost in the noise"
"""Why an effect of less than CONTRIBUTION is not named."""

ONE_FOR_SEVERAL = 0.07
"""Part of the gain of several effects of the motion that is given away for one that is none of them; on one sine, where
rate, heading, thrust and their derivatives are functions of one phase, none of the several may bring less."""

IN_ONE_SWING = 0.25
"""Both where the one sine is the swing of a closed loop: there the equation is biased, too."""

FAINT = 0.0075
"""Part of the variance that all effects explain, below which one that lasts is not named: as much is left of the
others if their shapes are wrong by a twelfth of their amplitude."""

PROVEN = 0.9
"""Free-run error, in parts of that without an effect, below which neither a residual that rose nor being FAINT is an
objection: what is left of a wrong shape makes no free run so much better."""


def given_away(problem: Problem) -> float:
    """Part of what several effects of the motion gain that does not tell them from one."""
    return IN_ONE_SWING if problem.one_sine and problem.closed_loop else ONE_FOR_SEVERAL


def pays(problem: Problem, free_run: FreeRun, new: Hypothesis, old: Hypothesis) -> bool:
    """Whether the free run gets better: by more than chance, or at all where the equation leaves no doubt.

    Or where no thrust drove it: all that a free run then holds is the effect and the decay of the first rate.
    """
    no_doubt = new.criterion - old.criterion > STRONG or float(np.ptp(problem.signals.torque)) == 0.0
    return free_run.better(new, old) or (no_doubt and free_run(new) < free_run(old))


def objection(problem: Problem, free_run: FreeRun, base: Hypothesis) -> tuple[str, int]:
    """What speaks against one effect of a hypothesis, and which; empty if nothing does."""
    reason, k = sound(problem, base)
    if reason:
        return reason, k
    gains = [evidence(problem, base, j) for j in range(len(base.terms))]
    asked = [required_gain(problem, base, j) for j in range(len(gains))]
    k = min(range(len(gains)), key=lambda j: gains[j] - asked[j])
    if gains[k] < asked[k]:
        return f"too little evidence for noise of this colour: 2 Δℓ is {gains[k]:.0f}, {asked[k]:.0f} is asked", k
    faint = _faint(problem, base, gains)
    if faint is not None and not free_run(base) < PROVEN * free_run(without(problem, base, faint)):
        return "so little beside what the others explain that it may be the error of their shapes", faint
    terms = zip(base.effects, base.terms, strict=True)
    phased = [j for j, (e, t) in enumerate(terms) if e.of_phase and not below_sampling(t, problem)]
    if problem.one_sine and len(phased) > 1:
        k = min(phased, key=lambda j: gains[j])
        if gains[k] < given_away(problem) * (base.criterion - excepting(problem, base, phased).criterion):
            return "a command of one sine cannot tell it from the shape error of another effect of the motion", k
    for k, (effect, term) in enumerate(zip(base.effects, base.terms, strict=True)):
        less = without(problem, base, k)
        proven = free_run(base) < PROVEN * free_run(less)
        if not proven and effect.must_prove(term, problem.signals):
            return "it is so short that the noise's colour may pass for it, and the free run is not plainly better", k
        # at rest friction holds what the water would turn: with it that is seen, and the residual grows as it should
        if rose(base, less) and not proven and not effect.dry:
            return "with it the residual grows: it explains the residual's colour, not its size", k
        if not pays(problem, free_run, base, less):
            return (
                "it improves the torque equation, but the free run on unseen data gets no better than chance would "
                f"have it: {free_run(less):.3g} rad/s without it, {free_run(base):.3g} rad/s with it"
            ), k
    return "", 0


def _faint(problem: Problem, base: Hypothesis, gains: Sequence[float]) -> int | None:
    """Which effect explains less than FAINT of what all do: the least."""
    if len(base.terms) == 1:
        return None
    whole = 2.0 * (base.fit.log_likelihood - nothing(problem).fit.log_likelihood)
    k = min(range(len(gains)), key=lambda j: gains[j])
    return k if explained(problem, gains[k]) < FAINT * explained(problem, whole) else None


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
        if effect.whole and in_passing(problem, hypothesis, k) > PASSING:
            return "it acts but where the command jumps, and when that was, between two samples, nobody knows", k
    return "", 0


def sound(problem: Problem, hypothesis: Hypothesis) -> tuple[str, int]:
    """Why a hypothesis cannot stand (physics, size), and for which effect; an empty reason if it can."""
    reason, k = forbidden(problem, hypothesis)
    lost = [] if reason else lost_in_noise(hypothesis)
    return (LOST, lost[0]) if lost else (reason, k)
