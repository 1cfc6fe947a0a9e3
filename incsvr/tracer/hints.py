"""What the equation but hints at, for the torque's noise, and free runs that are driven by the plain command tell."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.effects import Effect
from incsvr.evidence import evidence
from incsvr.tracer.asked import HINT, WITNESSED, FreeRun
from incsvr.tracer.gates import forbidden
from incsvr.tracer.hypothesis import Hypothesis
from incsvr.tracer.problem import Problem
from incsvr.tracer.scan import scan, with_lead

MOST = 6
"""How many effects at which the equation hints are put before the free runs."""


def hinted(problem: Problem, free_run: FreeRun, base: Hypothesis, effects: Sequence[Effect]) -> Hypothesis:
    """`base` with the effect of which free runs tell the most, if that is beyond doubt; else `base`."""
    if not free_run.witness:
        return base
    others = [effect for effect in effects if effect.name not in base.names()]
    # a scan sees nothing of a friction that the damping carries until it is fitted again
    leads = [lead for lead in scan(problem, base, others) if lead.gain > HINT or not lead.effect.channels]
    best_of = {lead.effect.name: lead for lead in reversed(leads)}
    grown = [with_lead(problem, base, lead) for lead in best_of.values()]
    grown = [new for new in grown if not forbidden(problem, new)[0]]
    hints = [new for new in grown if evidence(problem, new, len(base.terms)) > HINT]
    hints = sorted(hints, key=lambda new: -new.criterion)[:MOST]
    best = max(hints, key=lambda new: free_run.needs(new, base), default=base)
    return best if best is not base and free_run.needs(best, base) > WITNESSED else base
