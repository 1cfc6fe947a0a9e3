"""What these recordings cannot tell from an effect that was found: computed, not listed by hand."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.effects import ALTERNATIVES, Effect
from incsvr.effects.modulation import LevelledThrustModulation
from incsvr.tracing.weak.acceptance import against_physics
from incsvr.tracing.weak.hypothesis import Hypothesis, noise_gain, settle, views
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.scan import best_leads, with_lead, without

TIE = 10.0
"""Alternatives within this much of the criterion explain the recordings as well."""

SHAPE = 0.05
"""Part of an effect's gain by which an alternative may fall short: no effect's true shape is known more closely."""

ON_ONE_SINE = 0.4
"""Part of an effect's gain by which an alternative may fall short where the command is one sine."""


def indistinguishable(problem: Problem, found: Hypothesis, k: int, effects: Sequence[Effect]) -> tuple[Hypothesis, ...]:
    """`found` with its k-th effect replaced by each alternative that explains the recordings as well, best first."""
    reduced = without(problem, found, k)
    taken = {*reduced.names(), found.terms[k].effect}
    # beside an inertia a thrust efficiency has nothing of its own: the two and the damping are one equation
    beside = [
        alternative
        for alternative in ALTERNATIVES
        if alternative.name != "thrust_efficiency" or "inertia" not in reduced.names()
    ]
    every = [*effects, *beside]
    others = [effect for effect in every if effect.name not in taken]
    tied: dict[str, Hypothesis] = {}
    for lead in best_leads(problem, reduced, others, 5):
        swapped = with_lead(problem, reduced, lead)
        s = views(problem, swapped).of(lead.effect)
        # what rests on how the noise is split between torque and water is no evidence
        split = noise_gain(problem, swapped.fit, lead.effect, swapped.terms[-1])
        split -= noise_gain(problem, found.fit, found.effects[k], found.terms[k])
        gain = found.criterion - reduced.criterion
        margin = TIE + SHAPE * gain + len(problem.blocks) * abs(split)
        if problem.one_sine and lead.effect.of_phase and found.effects[k].of_phase:
            # all of these are a few harmonics of the command: which fits best is decided by the catalogue's shape error
            margin += ON_ONE_SINE * gain
        term = swapped.terms[-1]
        if (
            swapped.criterion < found.criterion - margin
            or lead.effect.implausible(term, s)
            or lead.effect.slight(term, s)
        ):
            continue
        known = tied.get(lead.effect.name)
        if known is None or swapped.criterion > known.criterion:
            tied[lead.effect.name] = swapped
    other = _scaled_otherwise(problem, found, k, effects)
    if other is not None and other.criterion >= found.criterion - TIE - SHAPE * (found.criterion - reduced.criterion):
        tied.setdefault("inertia", other)
    return tuple(sorted(tied.values(), key=lambda h: -h.criterion))


def _scaled_otherwise(problem: Problem, found: Hypothesis, k: int, effects: Sequence[Effect]) -> Hypothesis | None:
    """`found` with a thrust scaled about a level of its own replaced by one about the channel's mean and an inertia.

    Both scale the whole thrust at the mean: which of them it is, the motion cannot say.
    """
    if not isinstance(found.effects[k], LevelledThrustModulation) or "inertia" in found.names():
        return None
    by_key = {effect.key: effect for effect in effects}
    about_mean, inertia = by_key.get(f"{found.terms[k].effect}/thrust"), by_key.get("inertia")
    if about_mean is None or inertia is None:
        return None
    terms = found.values()
    terms[k] = (about_mean, found.terms[k].inner, found.terms[k].coefficients[:1])
    swapped = settle(problem, [*terms, (inertia, (), ())], found)
    return None if against_physics(problem, swapped) else swapped
