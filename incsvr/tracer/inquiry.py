"""The inquiry: the search's best set of effects, and what validation, evidence and free run leave of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.effects import Effect, candidates
from incsvr.evidence import NORMAL_95, evidence, intervals
from incsvr.tracer.alignment import aligned, misread, realigned, reread, without_command
from incsvr.tracer.asked import LEVEL, THRESHOLD, told, worth
from incsvr.tracer.excitation import demand
from incsvr.tracer.gates import against_physics
from incsvr.tracer.hypothesis import Hypothesis, below_sampling, nothing, price, resettled, views
from incsvr.tracer.posing import pose_finer
from incsvr.tracer.problem import Problem
from incsvr.tracer.proof import Court
from incsvr.tracer.run import Run
from incsvr.tracer.scan import Lead, scan, with_lead, without
from incsvr.tracer.search import Search
from incsvr.tracer.thinned import hangs

HARM = 0.03
"""Part of the free-run error by which an effect must spoil the validation recordings to be dropped for it."""

VETOES = 3
"""How often validation recordings may refuse all that a search found."""

FEIGNED = 3
"""Effects that the noise of shorter blocks feigns, beside which what lasts but an instant must stand."""

AGREES = 2.0
"""Standard errors, of both together, by which longer and shorter blocks may differ about an effect."""

MISREAD = 0.1
"""Change of the noise's share, as read beside all effects, that asks for another search: beside one it was misread."""


@dataclass(frozen=True, slots=True)
class Case:
    """What is asked of which recordings.

    Attributes:
        problem: the equations of the fitted recordings.
        effects: of which these recordings can speak.
        court: where the findings are proven.
        pieces: held-out pieces of the fitted recordings, where the search judges.
        channels: extra streams that are used.
        feigned: names of effects that shorter blocks seem to hold and longer ones do not: noise of these equations.
        longer: the equations of the longer blocks where `problem` are those of shorter ones, else None.
    """

    problem: Problem
    effects: tuple[Effect, ...]
    court: Court
    pieces: Court
    channels: Sequence[str]
    feigned: frozenset[str] = frozenset()
    longer: Problem | None = None


def inquire(
    runs: Sequence[Run],
    inertia: float,
    validate: Sequence[Run] | None,
    names: Sequence[str],
    excluded: Mapping[str, str],
) -> tuple[Case, Hypothesis, dict[str, str]]:
    """What was asked, the effects that are proven, and why others are not among them; `excluded` ones are not asked
    for.
    """
    problem, linear = aligned(runs, inertia, names)
    case, found, hunt = _searched(problem, validate, names, excluded)
    # which of the two torques it is was decided beside fewer effects
    if problem.held and len(found.terms) > 1:
        problem = realigned(runs, linear, problem, found)
        if not problem.held:
            case, found, hunt = _searched(problem, validate, names, excluded, found)
    # an effect that a controller makes up for hides what it asks the thrust for, and so from the judge, too
    again = without_command(reread(runs, problem, found), hunt.promising)
    if misread(problem, again, MISREAD):
        case, found, hunt = _searched(again, validate, names, excluded, found)
    refused = hunt.refused
    found = _proven(case, _evident(case, found, refused), refused)
    found = _resolved(case, found, refused, runs)
    case, found = _looked_closer(case, found, refused, runs, validate)
    found = _proven(case, _evident(case, found, refused), refused)
    return case, found, refused


def _searched(
    problem: Problem,
    validate: Sequence[Run] | None,
    channels: Sequence[str],
    excluded: Mapping[str, str],
    before: Hypothesis | None = None,
) -> tuple[Case, Hypothesis, Search]:
    """What is asked, the best set of effects, and the search that knows why others are not in it.

    Effects are chosen on pieces held out of the fitted recordings: validation recordings never choose. Where they threw
    everything out, the search goes on without what they refused. What was found `before`, when noise or
    torque were read otherwise, is tried again.
    """
    court, pieces = Court.of(problem, validate), Court.of(problem, None, quick=True)
    case = Case(problem, demand(problem, candidates(channels, problem.signals.rate_name)), court, pieces, channels)
    refused = dict(excluded)
    vetoes = VETOES if validate else 0
    while True:
        effects = [effect for effect in case.effects if effect.name not in refused]
        given = None
        if before is not None and before.terms and not set(before.names()) & set(refused):
            given = resettled(problem, before)
        hunt = Search(problem, effects, pieces, problem.closed_loop, given=given, refused=dict(refused))
        best = hunt.run()
        found = _surviving(problem, court, best, hunt.refused) if court.validation else best
        if found.terms or not best.terms or not vetoes:
            return case, found, hunt
        refused |= {name: hunt.refused[name] for name in best.names()}
        vetoes -= 1


def _looked_closer(
    case: Case, found: Hypothesis, refused: dict[str, str], runs: Sequence[Run], validate: Sequence[Run] | None
) -> tuple[Case, Hypothesis]:
    """What lasts but an instant, found beside `found` in shorter blocks; with it these are the equations.

    What other effects, for which the longer blocks hold no evidence, would explain in the shorter ones is noise of
    their own: they are believed as far as evidence is left beside these.
    """
    brief = [effect for effect in case.effects if effect.brief and effect.name not in found.names()]
    finer = pose_finer(runs, case.problem, case.channels) if brief else case.problem
    if finer is case.problem:
        return case, found
    court, pieces = Court.of(finer, validate, finer=True), Court.of(finer, None, quick=True, finer=True)
    hunt = Search(finer, brief, pieces, finer.closed_loop, refused=dict[str, str]())
    base = resettled(finer, found)
    grown = hunt.climbed(base)
    if court.validation:
        grown = _surviving(finer, court, grown, hunt.refused)
    others = [effect for effect in case.effects if not effect.brief and effect.name not in base.names()]
    feigned = [lead for lead in scan(finer, base, others) if lead.score > THRESHOLD]
    grown = _beside_feigned(finer, feigned[:FEIGNED], base, grown, hunt.refused)
    grown = _agreed(case.problem, finer, base, grown, hunt.refused)
    # the shorter blocks had the last word on these
    refused |= {effect.name: hunt.refused[effect.name] for effect in brief if effect.name in hunt.refused}
    if not set(grown.names()) > set(found.names()):
        return case, found
    for name in grown.names():
        refused.pop(name, None)
    names = frozenset(lead.effect.name for lead in feigned)
    return Case(finer, case.effects, court, pieces, case.channels, names, case.problem), grown


def _beside_feigned(
    finer: Problem, feigned: Sequence[Lead], base: Hypothesis, grown: Hypothesis, refused: dict[str, str]
) -> Hypothesis:
    """`grown`, or `base` where too little is left of one of its new effects beside what the shorter blocks feign.

    Unless it explains more than any of that in its place: a scan promises more than there is, most of all of an
    inertia, which follows the gyro's noise.
    """
    if not feigned:
        return grown
    seen = views(finer, base)
    columns = [finer.blocks.mean(lead.effect.columns(seen.of(lead.effect), lead.inner, ())) for lead in feigned]
    answers = [seen.turned(lead.effect, lead.inner, (), mean) for lead, mean in zip(feigned, columns, strict=True)]
    beside = np.concatenate(columns, axis=1), np.concatenate(answers, axis=2)
    for k, effect in enumerate(grown.effects):
        asked = price(effect, effect.core, finer) + THRESHOLD
        if effect.name not in base.names() and evidence(finer, grown, k, beside) < asked:
            instead = max([base, *(with_lead(finer, base, lead) for lead in feigned)], key=worth)
            if worth(grown) > worth(instead):
                return grown
            also = feigned[0].effect.name if instead is base else instead.terms[-1].effect
            refused[effect.name] = (
                f"in blocks of {finer.blocks.period:.2g} s, where {also} seems to act as well, too little evidence for "
                "it is left beside that"
            )
            return base
    return grown


def _agreed(
    problem: Problem, finer: Problem, base: Hypothesis, grown: Hypothesis, refused: dict[str, str]
) -> Hypothesis:
    """`grown`, or `base` where the longer blocks, as far as they can tell, say another size of a new effect."""
    sizes, longer = intervals(finer, grown), resettled(problem, grown)
    for k, (shorter, long) in enumerate(zip(sizes, intervals(problem, longer), strict=True)):
        for name, ends in shorter.items() if grown.effects[k].name not in base.names() else ():
            (here, doubt), (there, other) = (_middle(*x) for x in (ends, long[name]))
            if abs(here - there) > AGREES * np.hypot(doubt, other):
                refused[grown.effects[k].name] = (
                    f"its {name} would be {here:.3g} in blocks of {finer.blocks.period:.2g} s, and {there:.3g} in "
                    f"blocks of {problem.blocks.period:.2g} s: more than the noise of the two"
                )
                return base
    return grown


def _middle(low: float, high: float) -> tuple[float, float]:
    """Estimate and standard error of a 95 % interval."""
    return 0.5 * (low + high), 0.5 * (high - low) / NORMAL_95


def _surviving(problem: Problem, court: Court, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects that do no harm on the validation recordings: those can only drop an effect, never choose one."""
    nothing_added = court(nothing(problem))
    while found.terms:
        whole = court(found)
        less = [without(problem, found, k) for k in range(len(found.terms))]
        # what is left must still stand by itself: without the inertia a delay may turn into its opposite
        best = min(range(len(less)), key=lambda k: (bool(against_physics(problem, less[k])), court(less[k])))
        if court(less[best]) >= (1.0 - HARM) * whole and whole < nothing_added:
            return found
        refused[found.terms[best].effect] = (
            f"the free run on the validation recordings: {court(less[best]):.3g} rad/s without it, {whole:.3g} rad/s "
            f"with it, {nothing_added:.3g} rad/s without any effect"
        )
        found = less[best]
    return found


def _evident(case: Case, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects whose own p-value, all others fitted beside them, is below LEVEL."""
    while found.terms:
        p = [p_value_of(case, found, k) for k in range(len(found.terms))]
        # What is below the sampling is no finding but the alignment of the streams: it is told apart later.
        asked = [k for k, term in enumerate(found.terms) if not below_sampling(term, case.problem)]
        doubtful = [k for k in asked if p[k] > LEVEL]
        if not doubtful:
            return found
        worst = max(doubtful, key=lambda k: p[k])
        refused[found.terms[worst].effect] = (
            f"noise of this colour brings forth as much: its p-value, corrected for the search, is {p[worst]:.2g}, "
            f"below {LEVEL:.0e} is asked"
        )
        found = without(case.problem, found, worst)
    return found


def _resolved(case: Case, found: Hypothesis, refused: dict[str, str], runs: Sequence[Run]) -> Hypothesis:
    """The effects that do not hang on how often the torque was sampled.

    When a command of levels jumps, half its samples do not know: there every effect of the motion would hang on them.
    """
    while not case.problem.command.stays and found.terms and (worst := hangs(case.problem, found, runs, case.channels)):
        k, reason = worst
        refused[found.terms[k].effect] = reason
        found = without(case.problem, found, k)
    return found


def _proven(case: Case, found: Hypothesis, refused: dict[str, str]) -> Hypothesis:
    """The effects with which the free run of the proof gets better: the search saw but a quick one."""
    nothing_added = case.court(nothing(case.problem))
    while found.terms and case.court(found) >= nothing_added:
        p = [p_value_of(case, found, k) for k in range(len(found.terms))]
        worst = int(np.argmax(p))
        refused[found.terms[worst].effect] = (
            f"the free run on unseen data gets no better: {nothing_added:.3g} rad/s without any effect, "
            f"{case.court(found):.3g} rad/s with it"
        )
        found = without(case.problem, found, worst)
    return found


def p_value_of(case: Case, found: Hypothesis, k: int) -> float:
    """p-value of the k-th effect beside the others, corrected for the search."""
    gain = evidence(case.problem, found, k)
    return told(case.problem, case.pieces, found, k, gain, len(case.effects))
