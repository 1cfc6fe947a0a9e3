"""The inquiry: the search's best set of effects, and what validation, evidence and free run leave of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.effects import Effect, candidates
from incsvr.tracing.run import Run
from incsvr.tracing.statistics import p_value
from incsvr.tracing.weak.acceptance import against_physics, forbidden, objection
from incsvr.tracing.weak.alignment import aligned
from incsvr.tracing.weak.evidence import evidence
from incsvr.tracing.weak.excitation import demand
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, nothing, settle
from incsvr.tracing.weak.indistinguishable import SHAPE, indistinguishable
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import LEVEL
from incsvr.tracing.weak.scan import without
from incsvr.tracing.weak.search import Search
from incsvr.tracing.weak.validation import Validation

HARM = 0.03
"""Part of the free-run error by which an effect must spoil the validation recordings to be dropped for it."""

VETOES = 3
"""How often validation recordings may refuse all that a search found."""


Indistinguishable = tuple[tuple[Hypothesis, ...], ...]
"""Of each effect the hypotheses with another in its place that explain as much, best first."""


@dataclass(frozen=True, slots=True)
class Case:
    """What is asked of which recordings.

    Attributes:
        problem: the equations of the fitted recordings.
        effects: of which these recordings can speak.
        proof: where the findings are proven.
        pieces: held-out pieces of the fitted recordings, where the search judges.
        channels: extra streams that are used.
    """

    problem: Problem
    effects: tuple[Effect, ...]
    proof: Validation
    pieces: Validation
    channels: Sequence[str]


def chosen_effects(
    runs: Sequence[Run],
    inertia: float,
    validate: Sequence[Run] | None,
    names: Sequence[str],
    excluded: Mapping[str, str],
    holds: bool | None,
) -> tuple[Case, Hypothesis, Indistinguishable, dict[str, str]]:
    """What was asked, the effects that are proven, what explains as much as each of them, and why others are not among
    them; `excluded` ones are not asked for, and `holds` says whether the torque is a command, if that is told.
    """
    problem = aligned(runs, inertia, names, holds)
    case, found, refused = _searched(problem, validate, names, excluded)
    while True:
        # what one test takes out may leave another effect against physics, or without evidence
        proven, alternatives = _beyond_sampling(case, _proven(case, _evident(case, found, refused), refused), refused)
        if proven.names() != found.names():
            found = proven
            continue
        one = _one_for_all(case, proven, alternatives)
        if one is None:
            return case, proven, alternatives, refused
        found = one


def _searched(
    problem: Problem, validate: Sequence[Run] | None, channels: Sequence[str], excluded: Mapping[str, str]
) -> tuple[Case, Hypothesis, dict[str, str]]:
    """What is asked, the best set of effects, and why others are not in it.

    Effects are chosen on pieces held out of the fitted recordings: validation recordings never choose. Where they threw
    everything out, the search goes on without what they refused.
    """
    proof, pieces = Validation.of(problem, validate), Validation.of(problem, None, quick=True)
    every = candidates(channels, problem.signals.rate_name, problem.signals.one_clock)
    case = Case(problem, demand(problem, every), proof, pieces, channels)
    refused = dict(excluded)
    vetoes = VETOES if validate else 0
    while True:
        effects = [effect for effect in case.effects if effect.name not in refused]
        search = Search(problem, effects, pieces, problem.closed_loop, refused=dict(refused))
        best = search.run()
        found = _surviving(problem, proof, best, search.refused) if proof.validation else best
        if found.terms or not best.terms or not vetoes:
            return case, found, search.refused
        refused |= {name: search.refused[name] for name in best.names()}
        vetoes -= 1


def _surviving(problem: Problem, proof: Validation, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects that do no harm on the validation recordings: those can only drop an effect, never choose one."""
    nothing_added = proof(nothing(problem))
    while found.terms:
        error = proof(found)
        reduced = [without(problem, found, k) for k in range(len(found.terms))]
        # what is left must still stand by itself: without the inertia a delay may turn into its opposite
        best = min(range(len(reduced)), key=lambda k: (bool(against_physics(problem, reduced[k])), proof(reduced[k])))
        if proof(reduced[best]) >= (1.0 - HARM) * error and error < nothing_added:
            return found
        refused[found.terms[best].effect] = (
            f"the free run on the validation recordings: {proof(reduced[best]):.3g} rad/s without it, {error:.3g} "
            f"rad/s with it, {nothing_added:.3g} rad/s without any effect"
        )
        found = reduced[best]
    return found


def _evident(case: Case, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects that physics allows and whose own p-value is below LEVEL, all others fitted beside them."""
    while found.terms:
        reason, k = forbidden(case.problem, found)
        if reason:
            refused[found.terms[k].effect] = reason
            found = without(case.problem, found, k)
            continue
        p = [p_value_of(case, found, k) for k in range(len(found.terms))]
        # What is below the sampling is no finding but the alignment of the streams: it is told apart later.
        judged = [k for k, term in enumerate(found.terms) if not below_sampling(term, case.problem)]
        doubtful = [k for k in judged if p[k] > LEVEL]
        if not doubtful:
            return found
        worst = max(doubtful, key=lambda k: p[k])
        refused[found.terms[worst].effect] = (
            f"noise of this colour brings forth as much: its p-value, corrected for the search, is {p[worst]:.2g}, "
            f"below {LEVEL:.0e} is asked"
        )
        found = without(case.problem, found, worst)
    return found


def _proven(case: Case, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects with which the free run of the proof gets better: the search saw but a quick one."""
    nothing_added = case.proof(nothing(case.problem))
    while found.terms and case.proof(found) >= nothing_added:
        p = [p_value_of(case, found, k) for k in range(len(found.terms))]
        worst = int(np.argmax(p))
        refused[found.terms[worst].effect] = (
            f"the free run on unseen data gets no better: {nothing_added:.3g} rad/s without any effect, "
            f"{case.proof(found):.3g} rad/s with it"
        )
        found = without(case.problem, found, worst)
    return found


def _beyond_sampling(case: Case, found: Hypothesis, refused: dict[str, str]) -> tuple[Hypothesis, Indistinguishable]:
    """The effects that no delay or lag below the sampling explains as well, which is how the streams were sampled; and
    what else explains as much as each of them."""
    alternatives: list[tuple[Hypothesis, ...]] = []
    for k, term in enumerate(found.terms):
        if below_sampling(term, case.problem):
            alternatives.append(())
            continue
        alternatives.append(indistinguishable(case.problem, found, k, case.effects))
        for other in (alternative.terms[-1] for alternative in alternatives[-1]):
            if below_sampling(other, case.problem):
                kind = "delay" if other.effect == "torque_delay" else "lag"
                refused[term.effect] = (
                    f"a {kind} of {other.coefficients[0]:.2g} s explains as much: less than a sample of the streams "
                    f"({case.problem.resolution:.2g} s), it is how they were sampled"
                )
                return _beyond_sampling(case, without(case.problem, found, k), refused)
    return found, tuple(alternatives)


def _one_for_all(case: Case, found: Hypothesis, alternatives: Indistinguishable) -> Hypothesis | None:
    """One effect that explains as much as several which each cannot be told from it: it says the same with less.

    Under a few levels of thrust a curve and an inertia together pass for a dead band, of which every level loses the
    same.
    """
    if len(found.terms) < 2:
        return None
    base = nothing(case.problem)
    for alternative in alternatives[0]:
        term, effect = alternative.terms[-1], alternative.effects[-1]
        if any(term.effect not in {other.terms[-1].effect for other in others} for others in alternatives[1:]):
            continue
        one = settle(case.problem, [(effect, term.inner, ())], base, frozenset({effect.key}))
        enough = base.criterion + (1.0 - SHAPE) * (found.criterion - base.criterion)
        if one.criterion >= enough and not objection(case.problem, case.pieces, one)[0]:
            return one
    return None


def p_value_of(case: Case, found: Hypothesis, k: int) -> float:
    """p-value of the k-th effect beside the others, corrected for the search."""
    effect = found.effects[k]
    freedom, looks = effect.core + len(effect.sought), effect.looks * max(len(case.effects), 1)
    return p_value(evidence(case.problem, found, k), freedom, looks)
