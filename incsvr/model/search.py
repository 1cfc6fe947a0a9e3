"""The search for what a model lacks: one effect at a time, judged by a predictor on windows that its fit excluded."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from incsvr.model.candidates import (
    Candidate,
    candidates,
    imitates,
    joined,
    of_curve,
    other_shape,
    rank,
    scales_thrust,
    without,
)
from incsvr.model.directions import Evidence, directions
from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit, fit
from incsvr.model.left_out import Gain, gain, left_out
from incsvr.model.predictor import Predictor, anew, converged
from incsvr.model.rows import Row
from incsvr.model.series import effort_of, period
from incsvr.model.structure import Structure
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Added:
    """An effect that a model lacked.

    Attributes:
        name: of the effect.
        candidate: its parameters.
        gain: of the logarithm of the likelihood, with all parameters fitted anew.
        evidence: as it was added.
        alike: other effects that explain the recordings as well.
        other: the effect in its other shape, where that gains at least half as much; forms are inexact.
    """

    name: str
    candidate: Candidate
    gain: float
    evidence: Evidence
    alike: tuple[str, ...]
    other: Candidate | None = None


@dataclass(frozen=True)
class Trial:
    """An effect that is fitted beside those that were added.

    Attributes:
        candidate: its parameters, as fitted.
        fit: the model with it.
        evidence: of its first step.
        gain: of the logarithm of the likelihood, with all parameters fitted anew.
        convinces: whether it predicts excluded windows clearly better.
    """

    candidate: Candidate
    fit: Fit
    evidence: Evidence
    gain: float
    convinces: bool


@dataclass(frozen=True)
class Found:
    """The result of a search.

    Attributes:
        fit: the model, as a predictor.
        added: effects in the order in which they were added.
        refused: names, with the reason.
        weighed: the last candidates, none of which was added, each with its evidence.
    """

    fit: Fit
    added: tuple[Added, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    weighed: tuple[tuple[Candidate, Evidence], ...] = ()


def search(
    base: Predictor,
    effects: Mapping[str, Sequence[Row]],
    most: int = 6,  # of a dozen vehicles none had more
    enough: float = 12.0,  # of the logarithm of the likelihood; the best of a hundred by chance reaches 8
    *,
    begun: Found | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Found:
    """Adds effects one at a time, while the best of them predicts excluded windows clearly better.

    Args:
        base: the model that may lack effects.
        effects: that may be added, by name the rows of each.
        begun: with which the search begins; None for the model without effects.
        say: takes a line for each decision.
    """
    begun = begun or Found(base.fit)
    found, added, refused = begun.fit, list(begun.added), dict(begun.refused)
    weighed = list[tuple[Candidate, Evidence]]()
    plain = base.fit.structure
    while len(added) < most * len(plain.axes):
        trials = _trials(found, base, effects, refused, weighed, enough, say)
        found, trials, again = _rebased(found, trials, enough)
        if again:
            say("begun anew with the colour that an effect left")
            continue
        best = [each for each in _best(trials, found) if not _is_rest(each, added)]
        if not best:
            break
        new = found.structure
        for each in best:
            say(f"added: {each.name}, {each.gain:.1f}, {each.evidence}, alike {each.alike}")
            new = joined(new, each.candidate)
        start = {name: value for each in best for name, value in each.candidate.start.items()}
        found = converged(fit(new, {**found.theta, **start}, found.problem, found.starts))
        if len(best) == 1:
            found = min(found, trials[best[0].name].fit, key=lambda each: each.value)
        before = list(added)
        added += best
        for each in before:  # an imitation is not needed any more beside what it imitated
            rest = converged(
                fit(without(found.structure, each.candidate, plain), found.theta, found.problem, found.starts)
            )
            if rest.value - found.value < enough:
                say(f"removed: {each.name}")
                refused[each.name] = f"with {' and '.join(one.name for one in best)} it explains nothing any more"
                found = rest
                added.remove(each)
        for each in _opposite(found, added):
            say(f"only smooths: {each.name}")
            refused[each.name] = "a lag and an opposite delay are not late together: they smooth the torque's noise"
            found = converged(
                fit(without(found.structure, each.candidate, plain), found.theta, found.problem, found.starts)
            )
            added.remove(each)
    return Found(found, tuple(added), refused, tuple(weighed))


def _opposite(found: Fit, added: Sequence[Added]) -> list[Added]:
    """A lag and a delay of an effort that together are late by less than half of its period."""
    named, result = {each.name: each for each in added}, list[Added]()
    for axis in found.structure.driven:
        pair = [named[name] for name in (f"lag@{axis}", f"spin@{axis}", f"delay@{axis}") if name in named]
        if len(pair) == 2:
            kind = pair[0].name.partition("@")[0]
            late = float(np.exp(found.theta[f"{kind}:{axis}"])) + found.theta[f"shift:{axis}"]
            result += pair if abs(late) < 0.5 * period(found.problem.windows.runs, effort_of(axis)) else []
    return result


def _is_rest(best: Added, added: Sequence[Added], share: float = 0.15) -> bool:
    """Whether an effect gains so little beside those of its axis that their inexact form explains it.

    What can imitate much gains twice as much so; beside anything else an inertia does not count, which has no form that
    could be inexact.
    """
    much = imitates(best.candidate)
    axis = best.name.partition("@")[2]
    own = [each for each in added if each.name.partition("@")[2] == axis]
    exact = [each.name for each in own if each.name.startswith("inertia@") and not much]
    before = sum(each.gain for each in own if each.name not in exact and not of_curve(each.candidate))
    return best.gain < (2.0 if much else 1.0) * share * before


def _trials(
    found: Fit,
    base: Predictor,
    effects: Mapping[str, Sequence[Row]],
    refused: dict[str, str],
    beside: list[tuple[Candidate, Evidence]],
    enough: float,
    say: Callable[[str], None],
    fitted: int = 5,  # of the effects of one axis that promise most; of each of several, two
) -> dict[str, Trial]:
    """The effects that promise most, fitted, by name; adds to `refused` those that drive the vehicle.

    Args:
        beside: takes all candidates with their evidence.
    """
    every = [
        each
        for each in candidates(found.structure, found.theta, effects, found.problem.windows)
        if each.name not in refused
        and not (scales_thrust(each.name) and is_noise(base.reliability, each.name.partition("@")[2]))
    ]
    beside.clear()
    if not every:
        return {}
    weighed = directions(found, every)
    beside += [(each, weighed.evidence(k)) for k, each in enumerate(every)]
    first: dict[str, tuple[Evidence, Candidate]] = {}
    for evidence, each in sorted(_promising(beside, enough), key=lambda one: -one[0].excluded.total):
        kind, _, axis = each.name.partition("@")
        once = f"{kind.partition(':')[0]}@{axis}" if imitates(each) else each.name  # of the instants of a step the best
        first.setdefault(once, (evidence, each))
    axes = found.structure.axes
    most = fitted if len(axes) == 1 else 2
    looked = [one for axis in axes for one in _of_axis(first.values(), axis)[:most]]
    known = {one[1].name for one in looked}
    # The colour that the errors have without these hides most of their gain.
    hidden = ("inertia@", "lag@", "spin@") if len(axes) == 1 else ("inertia@",)
    others = {
        each.name: (evidence, each)
        for each, evidence in sorted(beside, key=lambda one: one[1].excluded.total)
        if each.name.startswith(hidden) or (of_curve(each) and each.name in first)
    }
    looked += [one for name, one in others.items() if name not in known]
    sure = {each.name for _, each in convincing(beside, enough)}
    trials = dict[str, Trial]()
    for evidence, each in looked:
        new = _fitted(each, found)
        reached = found.value - new.value
        say(f"{each.name}: {reached:.1f}, {evidence}")
        if (axis := drives(new)) and not drives(found):
            refused[each.name] = f"with it {axis} drives itself at speeds that were recorded"
            continue
        convinces = reached >= enough and (each.name in sure or _gains(found, new, needed(each, enough)))
        at_end = replace(each, start={name: new.theta[name] for name in each.start})
        trials[each.name] = Trial(at_end, new, evidence, reached, convinces)
    return trials


def _rebased(
    found: Fit,
    trials: Mapping[str, Trial],
    enough: float,
    much: float = 0.2,  # of the best gain: so much makes another effect the best
) -> tuple[Fit, dict[str, Trial], bool]:
    """The fit with the gains and the colour that the best effect leaves, the trials beside it, and whether it gains so
    much that every trial has to begin there: what those gain without the effect is not the effect's."""
    changed = dict(trials)
    sure = [each for each in changed.values() if each.convinces]
    if not sure or len(found.structure.axes) > 1:
        return found, changed, False
    best = min(sure, key=lambda each: each.fit.value)
    new = anew(best.fit.structure, best.fit.theta, best.fit)
    if new.value < best.fit.value:
        best = replace(best, fit=new, gain=found.value - new.value)
        changed[best.candidate.name] = best
    theta = {name: best.fit.theta.get(name, found.theta[name]) for name in found.names}
    rest = converged(fit(found.structure, theta, best.fit.problem, best.fit.starts))
    less = found.value - rest.value
    if less <= 0.0:
        return found, changed, False
    for name, each in changed.items():
        changed[name] = replace(each, gain=each.gain - less, convinces=each.convinces and each.gain - less >= enough)
    return rest, changed, less > much * best.gain


def _best(trials: Mapping[str, Trial], found: Fit) -> list[Added]:
    """The best effect of each axis that convinces."""
    # Of two shapes the better one says how large the effect is, also where only the other one convinces.
    sure = [
        max(each, trials.get(other_shape(name), each), key=lambda one: one.gain)
        for name, each in trials.items()
        if each.convinces
    ]
    ofs = [[one for one in sure if one.candidate.name.endswith(f"@{axis}")] for axis in found.structure.axes]
    best = [_plainest(own) for own in ofs if own]
    others = [trials.get(other_shape(each.name)) for each in best]
    return [
        replace(each, other=shape.candidate) if shape is not None and shape.gain > 0.5 * each.gain else each
        for each, shape in zip(best, others, strict=True)
    ]


def _of_axis(every: Iterable[tuple[Evidence, Candidate]], axis: str) -> list[tuple[Evidence, Candidate]]:
    """The candidates of an axis."""
    return [one for one in every if one[1].name.endswith(f"@{axis}")]


def _plainest(trials: Sequence[Trial]) -> Added:
    """The plainest of the effects that gain about as much as the best."""
    top = max(one.gain for one in trials)
    equals = [one for one in trials if one.gain > top - max(5.0, 0.05 * top)]
    if all(imitates(one.candidate) for one in equals):  # what can imitate much has to be clearly better
        equals += [one for one in trials if one.gain > 0.85 * top and not imitates(one.candidate)]
    chosen = min(equals, key=lambda one: (*rank(one.candidate), -one.gain))
    alike = tuple(one.candidate.name for one in equals if one is not chosen)
    return Added(chosen.candidate.name, chosen.candidate, chosen.gain, chosen.evidence, alike)


def _fitted(candidate: Candidate, found: Fit) -> Fit:
    """The candidate fitted, from several starts where one may end beside the best.

    On one axis its errors have their own colour. A free inertia begins with the stamps as they are, too, because a
    wrong inertia passes for a shift; a delay begins with the shift that was found, too.
    """
    starts: list[dict[str, float]] = [{}]
    if candidate.name.startswith("inertia@"):
        starts.append({name: 0.0 for name in found.names if name.startswith("shift")})
    if candidate.name.startswith("delay@"):
        starts.append({name: found.theta[name] for name in candidate.start})
    fits = [
        fit(candidate.structure, {**found.theta, **candidate.start, **own}, found.problem, found.starts)
        for own in starts
    ]
    best = min(fits, key=lambda each: each.value)
    return converged(best) if len(found.structure.axes) == 1 else best  # of several axes that takes minutes


def _gains(found: Fit, new: Fit, enough: float) -> bool:
    """Whether a fit predicts excluded windows clearly better, each by the fit without its fold."""
    return is_clear(gain(left_out(found) - left_out(new), found.problem.windows), enough)


def is_clear(one: Gain, enough: float, agreeing: float = 0.75) -> bool:
    """Whether a gain on excluded windows is more than chance, and not that of a few of them: an effect that acts rarely
    has it from some of the blocks, what is no effect from one or two, and `agreeing` of the folds say the same."""
    return one.rest >= enough and one.agreeing >= agreeing


def convincing(weighed: Iterable[tuple[Candidate, Evidence]], enough: float = 12.0) -> list[tuple[Evidence, Candidate]]:
    """The candidates whose first step gains clearly on excluded windows, in a direction that makes sense."""
    return [
        (evidence, each)
        for evidence, each in _promising(weighed, enough)
        if is_clear(evidence.excluded, needed(each, enough)) and evidence.sure >= 4.0
    ]


def _promising(weighed: Iterable[tuple[Candidate, Evidence]], enough: float) -> list[tuple[Evidence, Candidate]]:
    """The candidates whose first step gains half of what is needed, in a direction that makes sense.

    Large errors weigh little in that step: an effect that acts at steps of the effort shows its gain when it is fitted.
    """
    found = []
    for each, evidence in weighed:
        wrong = each.one_sided and evidence.step[0] < 0.0
        wrong |= any(value < 0.0 and row.low > -np.inf for row, value in zip(each.rows, evidence.step, strict=False))
        if not wrong and evidence.excluded.total > 0.5 * needed(each, enough):
            found.append((evidence, each))
    return found


def needed(candidate: Candidate, enough: float) -> float:
    """The gain that a candidate needs: what can imitate much needs twice as much."""
    return (2.0 if imitates(candidate) else 1.0) * enough


def is_noise(reliability: Mapping[str, float], axis: str, least: float = 0.5) -> bool:
    """Whether less than half of the variance of an axis's effort is more than noise."""
    return reliability.get(axis, 1.0) < least


def drives(found: Fit) -> str:
    """The axis whose damping drives the vehicle at more than 1 % of the recorded speeds, or that products of velocities
    feed; empty where none does."""
    windows, structure = found.problem.windows, found.structure
    signals = {**windows.velocity, **windows.channel}
    for axis in structure.axes:
        own = windows.velocity[axis]
        moving = np.abs(own) > 0.1 * np.quantile(np.abs(own), 0.9)
        total = np.zeros_like(own)
        for row in structure.rows:
            if row.axis == axis and row.follows == axis:  # in steady motion a memory of the velocity is the velocity
                total += found.theta[row.key] * own
            elif row.drag and row.axis == axis:
                part = row.parts[0]
                total += found.theta[row.key] * one_by_one(part.one, signals) * one_by_one(part.other, signals)
        if np.mean((total * own)[moving] < 0.0) > 0.01:
            return axis
    return _fed(structure, found.theta, windows.velocity)


def _fed(
    structure: Structure,
    theta: Mapping[str, float],
    velocity: Mapping[str, Array],
    most: float = 0.1,  # of the tanker's models those with 0.05 predict its other manoeuvres, those with 0.2 diverge
) -> str:
    """The axis into which products of velocities put the most energy, where all together put in more than a share of
    what they take out; empty where they do not."""
    power = {axis: np.zeros_like(own) for axis, own in velocity.items()}
    for row in structure.rows:
        for part in row.parts:
            if {part.one.of, part.other.of} <= {*structure.axes, ""} and part.one.of:
                factors = one_by_one(part.one, velocity) * one_by_one(part.other, velocity)
                power[part.axis] += theta[row.key] * part.sign * factors * velocity[part.axis]
    whole = np.sum(list(power.values()), axis=0)
    if -whole[whole < 0.0].sum() <= most * whole[whole > 0.0].sum():
        return ""
    return min(power, key=lambda axis: float(power[axis].sum()))
