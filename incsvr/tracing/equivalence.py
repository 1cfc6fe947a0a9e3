"""Sets of effects that these recordings cannot distinguish: their difference is within its error."""

from __future__ import annotations

from incsvr.model_trace.thresholds import MAX_ALTERNATIVES
from incsvr.tracing.candidates import leads
from incsvr.tracing.search import FittedHypothesis, Search


def alternatives(search: Search, best: FittedHypothesis, k: int) -> list[FittedHypothesis]:
    """Hypotheses with another effect, their last, in the k-th one's place, that predict unseen data as well."""
    part, rest = best.hypothesis.parts[k], search.tried(best.hypothesis.without(k), best.fitted)
    found: dict[str, FittedHypothesis] = {}
    for lead in leads(search.problem, rest.fitted, search.effects, MAX_ALTERNATIVES, 0):
        if lead.part.name == part.name:
            continue
        tried = search.tried(rest.hypothesis.with_part(lead.part), rest.fitted)
        if search.alike(best, tried) and lead.part.name not in found and not search.why_not(tried, rest):
            found[lead.part.name] = tried
    return list(found.values())


def simplest_equivalent(search: Search, best: FittedHypothesis) -> FittedHypothesis:
    """`best`, where each effect that the recordings cannot tell from one of fewer free numbers is that one."""
    for k in range(len(best.names)):
        fewer = [other for other in alternatives(search, best, k) if other.size < best.size]
        if fewer:
            return simplest_equivalent(search, min(fewer, key=lambda each: (each.size, -float(each.score.sum()))))
    return best
