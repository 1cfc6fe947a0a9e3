"""The search for what a model lacks: one candidate at a time, fitted with all the rest, judged on excluded windows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import ndtri

from incsvr.model.candidates import Candidate, candidates, of_estimator, rank
from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit, fit, slopes_of, unit
from incsvr.model.intervals import covariance
from incsvr.model.left_out import Gain, gain, left_out
from incsvr.model.rows import Row
from incsvr.model.series import effort_of, period
from incsvr.model.structure import is_logarithm
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence for an effect.

    Attributes:
        sure: deviations by which the predictor's coefficient is away from where it does nothing.
        apart: difference of the simulation's coefficient, in what the two may differ by.
        simulated, predicted: gains on excluded windows.
    """

    sure: float
    apart: float
    simulated: Gain
    predicted: Gain

    @property
    def weight(self) -> float:
        """Deviations of the coefficient and of both gains together, by which the best of several is chosen."""
        return self.sure + self.simulated.deviations + self.predicted.deviations

    @property
    def convinces(self) -> bool:
        """Whether both estimators gain: one of them clearly where their coefficients agree, else both clearly."""
        gains = (self.simulated, self.predicted)
        clear = sum(each.deviations >= 3.0 and each.agreeing >= 0.75 and each.total > 3.0 for each in gains)
        enough = clear > 0 if self.apart <= 1.0 else clear > 1 and self.apart <= 2.0
        size = self.sure >= 6.0  # what is significant may be small: quiet missions reach 4 with nothing to find
        return size and enough and min(each.deviations for each in gains) > 0.0


@dataclass(frozen=True)
class Found:
    """The result of a search.

    Attributes:
        fit: the model, by simulation.
        check: the same, by prediction.
        added: names, in the order in which they were added, with the evidence for each.
        refused: names, with the reason.
        alike: of each that was added, the others that explain the recordings as well.
    """

    fit: Fit
    check: Fit
    added: tuple[tuple[str, Evidence], ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    alike: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class Trial:
    """A candidate that both estimators fitted: by simulation, by prediction; `sure` and `apart` as in `Evidence`."""

    candidate: Candidate
    fit: Fit
    check: Fit
    sure: float
    apart: float

    def as_good_as(self, other: Trial, margin: float = 5.0) -> bool:  # of the logarithm of the likelihood
        """Whether both of its fits explain the recordings as well as another's."""
        return self.check.value < other.check.value + margin and self.fit.value < other.fit.value + margin


def search(
    found: Fit,
    check: Fit,
    effects: Mapping[str, Sequence[Row]],
    most: int = 6,  # of a dozen vehicles none had more
    finalists: int = 4,  # of a round, whose folds are fitted anew
    *,
    say: Callable[[str], None] = lambda _: None,
) -> Found:
    """Adds effects one at a time, while two estimators agree on the best of them.

    The simulation shows what acts slowly, but is biased where a controller answers the water. The predictor is unbiased
    in both loops, but hardly shows what is slow. A wrong effect imitates another one, and differently in each:
    effects on which both agree are named (J. A. Hausman, Econometrica 46, 1978).

    Args:
        found: the model, fitted by simulation.
        check: the same, fitted by prediction.
        effects: that may be added, by name the rows of each.
        say: takes a line for each decision.
    """
    added, alike, refused = list[tuple[str, Evidence]](), dict[str, tuple[str, ...]](), dict[str, str]()
    for _ in range(most):
        trials = _trials(found, check, effects, refused)
        if not trials:
            break
        base, base_check = left_out(found, True), left_out(check, True)
        sound = []
        for trial in trials[:finalists]:
            evidence = Evidence(
                trial.sure,
                trial.apart,
                gain(base - left_out(trial.fit, True), trial.fit.problem.windows),
                gain(base_check - left_out(trial.check, True), trial.check.problem.windows),
            )
            say(f"{trial.candidate.name}: {evidence}")
            if evidence.convinces:
                sound.append((evidence, trial))
        if not sound:
            break
        best = max(sound, key=lambda one: one[0].weight)[1]
        equals = [one for one in sound if one[1].as_good_as(best)]
        evidence, chosen = min(equals, key=lambda one: rank(one[1].candidate.name))
        name = chosen.candidate.name
        say(f"added: {name}")
        added.append((name, evidence))
        others = [each.candidate.name for each in trials if each.check.value < chosen.check.value + 5.0]
        alike[name] = tuple(other for other in dict.fromkeys(others) if other != name)
        found, check = chosen.fit, chosen.check
    return Found(found, check, tuple(added), refused, alike)


def drives(found: Fit) -> str:
    """The axis whose damping drives the vehicle at more than 1 % of the recorded speeds; empty where none does."""
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
    return ""


def _trials(
    found: Fit,
    check: Fit,
    effects: Mapping[str, Sequence[Row]],
    refused: dict[str, str],
    looked: int = 6,  # candidates of each estimator that are fitted in full
) -> list[Trial]:
    """Candidates that both estimators fit better with, the most promising first; adds to `refused` those that drive."""
    every = [each for each in candidates(found.structure, effects, found.problem.windows) if each.name not in refused]
    count = max(len({each.name for each in every}), 1)
    needed = float(-ndtri(0.025 / count))  # the surest of so many passes it by chance once in twenty
    kept = _promising(found, every, looked)
    names = {(each.name, each.own) for each in kept}
    kept += [each for each in _promising(check, every, looked) if (each.name, each.own) not in names]
    trials = []
    for each in kept:
        trial = _tried(each, found, check)
        if trial is None or trial.sure < needed:
            continue
        if (axis := drives(trial.fit)) and not drives(found):
            refused[each.name] = f"with it {axis} drives itself at speeds that were recorded"
            continue
        trials.append(trial)
    if not trials:
        return []
    base = left_out(found)
    promise = [gain(base - left_out(each.fit), each.fit.problem.windows).deviations + each.sure for each in trials]
    return [trials[k] for k in np.argsort(-np.array(promise))]


def _with(base: Fit, candidate: Candidate, rounds: int = 8) -> Fit:
    """The candidate on top of a base, be it a simulation or a predictor."""
    structure = of_estimator(candidate.structure, base.structure)
    return fit(structure, {**base.theta, **candidate.start}, base.problem, base.starts, rounds=rounds)


def _tried(candidate: Candidate, found: Fit, check: Fit) -> Trial | None:
    """A candidate fitted by simulation and by prediction, None where one of them does not gain.

    Their coefficients may differ by two deviations and a tenth of the size.
    """
    new, predicted, name = _with(found, candidate), _with(check, candidate), candidate.own
    if new.value > found.value - 3.0 or predicted.value > check.value - 3.0:
        return None
    at = predicted.names.index(name)
    deviation = float(np.sqrt(covariance(predicted)[at, at]))
    size = 1.0 if is_logarithm(name) else abs(new.theta[name])
    apart = abs(new.theta[name] - predicted.theta[name]) / (2.0 * deviation + 0.1 * size + 1e-300)
    return Trial(candidate, new, predicted, _sureness(predicted, candidate), apart)


def _promising(found: Fit, every: Sequence[Candidate], count: int, screened: int = 8) -> list[Candidate]:
    """The candidates that gain most after two rounds of a fit, of one name the best start.

    Of many rows only the `screened` ones whose first step promises most are fitted at all.
    """
    rows = [each for each in every if each.rows]
    if len(rows) > screened:
        promised = _first_steps(found, [each.rows for each in rows])
        chosen = {id(rows[k]) for k in np.argsort(-promised)[:screened]}
        every = [each for each in every if not each.rows or id(each) in chosen]
    if len(every) <= count:
        return list(every)
    best: dict[str, tuple[float, Candidate]] = {}
    for each in every:
        value = found.value - _with(found, each, rounds=2).value
        if each.name not in best or value > best[each.name][0]:
            best[each.name] = (value, each)
    return [each for _, each in sorted(best.values(), key=lambda pair: -pair[0])[:count]]


def _first_steps(found: Fit, groups: Sequence[tuple[Row, ...]]) -> Array:
    """(groups,) the gain of the first step towards the rows of each group, with all parameters free (Rao's score)."""
    rows = list({row.key: row for group in groups for row in group}.values())
    more = found.structure.plus(rows=rows)
    names = {row.key for row in rows}
    theta = {**dict.fromkeys(names, 0.0), **found.theta}
    units = np.array([unit(name, more, theta, found.problem.windows) for name in more.names])
    point = np.array([theta[name] for name in more.names])
    state = slopes_of(more, point, found.problem, found.starts, found.scale, units)
    new = np.array([name in names for name in more.names])
    normal, slope = state.normal.sum(axis=0), state.gradient.sum(axis=0)
    normal += 1e-9 * np.diag(np.diag(normal))
    across = np.linalg.solve(normal[np.ix_(~new, ~new)] + np.diag(found.prior), normal[np.ix_(~new, new)])
    rest = slope[new] - across.T @ slope[~new]
    inner = normal[np.ix_(new, new)] - normal[np.ix_(~new, new)].T @ across
    inner += 1e-6 * np.diag(np.diag(normal)[new])
    place = {name: k for k, name in enumerate(name for name in more.names if name in names)}
    promised = []
    for group in groups:
        at = [place[row.key] for row in group]
        step = np.linalg.solve(inner[np.ix_(at, at)], rest[at])
        forbidden = any(value < row.low for row, value in zip(group, step, strict=True))
        promised.append(0.0 if forbidden else 0.5 * float(rest[at] @ step))
    return np.array(promised)


def _sureness(new: Fit, candidate: Candidate) -> float:
    """How many deviations the candidate's own parameters are away from where they do nothing."""
    spread = covariance(new)
    if candidate.rows:
        at = [new.names.index(row.key) for row in candidate.rows]
        value = np.array([new.theta[row.key] for row in candidate.rows])
        square = float(value @ np.linalg.lstsq(spread[np.ix_(at, at)], value, rcond=1e-12)[0])
        return float(np.sqrt(max(square - (len(at) - 1), 0.0)))
    kind, _, axis = candidate.own.partition(":")
    at_ = new.names.index(candidate.own)
    size, deviation = new.theta[candidate.own], max(float(np.sqrt(spread[at_, at_])), 1e-9)
    if kind in ("lag", "dead"):  # logarithms: nothing at minus infinity; sure where the interval is narrow
        return 1.0 / deviation
    if kind == "limit":
        return (float(np.log(new.problem.windows.largest(effort_of(axis)))) - size) / deviation
    if kind == "shift":  # streams on two clocks differ by up to a period
        return (abs(size) - period(new.problem.windows.runs, effort_of(axis))) / deviation
    return abs(size - (candidate.start[candidate.own] if kind == "mass" else 0.0)) / deviation
