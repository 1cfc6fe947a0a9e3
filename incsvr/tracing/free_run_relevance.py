"""The named effects that the free run confirms: others are dropped."""

from __future__ import annotations

import numpy as np

from incsvr.model_trace.sentences import irrelevance
from incsvr.model_trace.thresholds import RELEVANT_FREE_RUN_SHARE
from incsvr.tracing.search import FittedHypothesis, Search
from incsvr.tracing.validation import free_runs


def without_unseen_effects(search: Search, best: FittedHypothesis) -> FittedHypothesis:
    """`best` without the effects that free runs over held-out pieces can do without.

    In closed loop nothing goes: where a controller answers the water, a free run proves nothing.
    """
    if search.problem.of_innovations:
        return best
    while best.names:
        whole = free_runs(search.problem, best.fitted)
        without = [search.tried(best.hypothesis.without(k), best.fitted) for k in range(len(best.names))]
        gains = [1.0 - float(np.median(whole / free_runs(search.problem, each.fitted))) for each in without]
        least = min(range(len(gains)), key=gains.__getitem__)
        if gains[least] >= RELEVANT_FREE_RUN_SHARE:
            return best
        search.taken_back.add(best.names[least])
        search.refused[best.names[least]] = irrelevance(gains[least])
        best = without[least]
    return best
