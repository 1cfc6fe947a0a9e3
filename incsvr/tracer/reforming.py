"""A hypothesis settled once more: its searched parameters found again, in other forms, or from other starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from incsvr.effects import Effect
from incsvr.tracer.asked import worth
from incsvr.tracer.gates import against_physics
from incsvr.tracer.hypothesis import Hypothesis, settle, views
from incsvr.tracer.problem import Problem
from incsvr.tracer.scan import Lead, instead, scan, with_lead, without

OUT = 0.01
"""Of its range: a searched parameter that ended so near to an end of it would go on."""

RETRIES = 2
"""How many other starts are tried then."""

FORMS = 2
"""How many other forms of an effect are tried in its place."""


def reformed(problem: Problem, effects: Sequence[Effect], base: Hypothesis) -> Hypothesis:
    """`base` with its searched parameters found again, or with another form of one of its effects.

    What is best alone may have taken on what another effect was then added for.
    """
    best = base
    searched = frozenset(effect.key for effect in base.effects if effect.searched)
    if searched:
        again = settle(problem, base.values(), base, searched, passes=8)
        if worth(again) > worth(best) and not against_physics(problem, again):
            best = base = again
    for k, effect in enumerate(base.effects):
        forms = [e for e in effects if e.name == effect.name and e.key != effect.key]
        if not forms:
            continue
        for lead in scan(problem, without(problem, base, k), forms)[:FORMS]:
            new = instead(problem, base, [k], lead)
            if worth(new) > worth(best) and not against_physics(problem, new):
                best = new
    return best


def held_back(problem: Problem, base: Hypothesis, lead: Lead, new: Hypothesis) -> Hypothesis:
    """`new`; where the search of the lead's parameter ran out of its range, and of physics, what it comes to from
    the next starts: a wrong shape may be best where the effect is no longer itself."""
    effect = lead.effect
    if not effect.searched or not against_physics(problem, new):
        return new
    seen = views(problem, base).of(effect)
    low, high = effect.bounds(seen)
    if low + OUT * (high - low) < new.terms[-1].inner[-1] < high - OUT * (high - low):
        return new
    others = [start for start in effect.starts(seen) if start[:-1] == lead.inner[:-1]]
    others = sorted(others, key=lambda start: abs(start[-1] - lead.inner[-1]))[1 : 1 + RETRIES]
    tries = (with_lead(problem, base, replace(lead, inner=start)) for start in others)
    return next((again for again in tries if not against_physics(problem, again)), new)
