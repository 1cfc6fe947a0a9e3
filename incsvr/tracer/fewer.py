"""Fewer effects that explain as much, and which of two sets free runs prefer that see more than the equation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

from incsvr.effects import Effect
from incsvr.tracer.asked import STRONG, FreeRun
from incsvr.tracer.gates import PROVEN, sound
from incsvr.tracer.hypothesis import Hypothesis
from incsvr.tracer.problem import Problem
from incsvr.tracer.scan import excepting, instead, scan, without

SIMPLER, SEEN_SIMPLER = 0.35, 0.6
"""Parts of an effect's gain that are given away for one effect less: always, and where free runs are without the
torque's noise and show it none the better."""

SENSORS = 0.5
"""Share of the noise in the torque above which free runs that are driven by known levels see more than the equation."""


def simpler(problem: Problem, free_run: FreeRun, effects: Sequence[Effect], base: Hypothesis) -> Hypothesis:
    """`base` without an effect that another form of one of the others explains as well.

    A thrust scaled by a channel about another level is the same about the channel's mean, and another inertia; a
    tether untwisted at another heading, and a constant moment. What says the same also runs as well.
    """
    for k, less in permutations(range(len(base.terms)), 2):
        forms = [e for e in effects if e.name == base.effects[k].name and _otherwise(problem, e, base.effects[k])]
        if not forms:
            continue
        others = excepting(problem, base, (k, less))
        gained = base.criterion - without(problem, base, less).criterion
        for lead in scan(problem, others, forms):
            same = lead.effect.key == base.effects[k].key
            for inner in lead.effect.starts(problem.signals) if same else [lead.inner]:
                one = instead(problem, base, (k, less), replace(lead, inner=inner))
                lost = base.criterion - one.criterion
                if lost <= max(SIMPLER, SEEN_SIMPLER) * gained and not sound(problem, one)[0]:
                    nearly = lost <= SIMPLER * gained and PROVEN * free_run(one) <= free_run(base)
                    if nearly or runs_as_well(problem, free_run, one, base):
                        return simpler(problem, free_run, effects, one)
    return base


def runs_as_well(problem: Problem, free_run: FreeRun, one: Hypothesis, base: Hypothesis) -> bool:
    """Whether free runs that are driven by the plain command get no worse by fewer effects: they see more than the
    equation, in which the torque's noise is."""
    return problem.signals.known and free_run(one) <= free_run(base)


def runs_better(problem: Problem, free_run: FreeRun, new: Hypothesis, old: Hypothesis) -> bool:
    """Whether free runs that are driven by known levels leave no doubt that `new` is better, either as the noise of
    the two has it: where the noise is the torque sensor's they see more than the equation."""
    if not (free_run.witness and problem.command.exact and problem.signals.share > SENSORS):
        return False
    return free_run.tells(new, old) > STRONG and free_run.tells(old, new) < -STRONG


def _otherwise(problem: Problem, form: Effect, effect: Effect) -> bool:
    """Whether `form` may stand for the effect in another way: another form, or the same from elsewhere."""
    settles = form.searched or form.curved  # to one value, wherever it began
    return form.key != effect.key or (not settles and len(form.starts(problem.signals)) > 1)
