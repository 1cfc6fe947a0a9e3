"""The search for what a model lacks: one candidate at a time, each fitted with all the rest, judged where it was left out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import ndtri

from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit, fit, slopes_of, unit
from incsvr.model.intervals import covariance
from incsvr.model.left_out import Gain, gain_of, left_out
from incsvr.model.rows import Row
from incsvr.model.series import period, values
from incsvr.model.structure import Structure, is_logarithm
from incsvr.model.windows import Windows
from incsvr.numerics import Array


@dataclass(frozen=True)
class Candidate:
    """Something that a model may lack.

    Attributes:
        name: the effect.
        structure: the model with it.
        own: the parameter that tells whether it is there.
        start: parameters that it brings, and where their fit begins.
        rows: that it adds and that are nothing where their coefficients are; empty for what is no row.
    """

    name: str
    structure: Structure
    own: str
    start: Mapping[str, float]
    rows: tuple[Row, ...] = ()


@dataclass(frozen=True)
class Found:
    """What a search ended with.

    Attributes:
        fit: the model, by simulation.
        check: the same, by prediction.
        added: names, in the order in which they were added, with what speaks for each.
        refused: names, with the reason.
        alike: of each that was added, what explains the recordings as well.
    """

    fit: Fit
    check: Fit
    added: tuple[tuple[str, Evidence], ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    alike: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def candidates(structure: Structure, effects: Mapping[str, Sequence[Row]], windows: Windows) -> list[Candidate]:
    """Each effect by its rows, stage of an effort, delay, coupled inertia and free inertia that the structure does not have."""
    have = {row.key for row in structure.rows}
    found = []
    for name, rows in effects.items():
        new = [row for row in rows if row.key not in have]
        if not new or new[0] is not rows[0]:
            continue
        more = structure.plus(rows=new)
        start = {row.key: 0.0 for row in new}
        lags = new[0].lags or (None,)
        for lag in lags:
            times = {} if lag is None else {f"time:{new[0].key}": float(np.log(lag))}
            found.append(
                Candidate(
                    name if "@" in name else f"{name}@{new[0].axis}",
                    more,
                    new[0].key,
                    start | times,
                    tuple(new) if lag is None else (),
                )
            )
    for axis in structure.driven:
        top = windows.largest(structure.effort(axis))
        effort = values(windows.runs, structure.effort(axis))
        starts = {
            "lag": [np.log(2.0 * windows.step)],
            "dead": [np.log(0.05 * top), np.log(0.2 * top)],
            "limit": [np.log(0.8 * top), np.log(0.5 * top)],
            "exponent": [0.2, -0.2],
        }
        if np.quantile(effort, 0.05) < -0.05 * top and np.quantile(effort, 0.95) > 0.05 * top:
            starts["reverse"] = [0.0]
        for kind, each in starts.items():
            if (kind, axis) not in structure.stages:
                more = structure.plus(stages=[(kind, axis)])
                found += [
                    Candidate(f"{kind}@{axis}", more, f"{kind}:{axis}", {f"{kind}:{axis}": float(at)}) for at in each
                ]
        if structure.shift_priors.get(axis, np.inf) < 1e3:
            wide = replace(structure, shift_priors={**structure.shift_priors, axis: 1e6})
            found += [Candidate(f"delay@{axis}", wide, f"shift:{axis}", {})]
        if axis in structure.given:
            found.append(
                Candidate(
                    f"inertia@{axis}",
                    structure.plus(free=[axis]),
                    f"mass:{axis}",
                    {f"mass:{axis}": structure.given[axis]},
                )
            )
    return found


def search(
    found: Fit,
    check: Fit,
    effects: Mapping[str, Sequence[Row]],
    most: int = 6,  # of a dozen vehicles none had more
    looked: int = 6,  # candidates of each estimator that are fitted in full in a round
    finalists: int = 4,  # of them whose folds are fitted anew
    log: Callable[[str], None] | None = None,
) -> Found:
    """Adds effects one at a time, while two estimators agree on the best of them.

    The simulation knows what lasts, but a controller that answers the water bends it; the predictor is right in both loops,
    but hardly sees what is slow. A wrong effect stands in for something else, and does so differently in each: what they
    agree on is named (J. A. Hausman, Econometrica 46, 1978).

    Args:
        found: the model, fitted by simulation.
        check: the same, fitted by prediction.
        effects: that may be added, by name the rows of each.
    """
    added, alike, refused = list[tuple[str, Evidence]](), dict[str, tuple[str, ...]](), dict[str, str]()
    say = log or (lambda _: None)
    for _ in range(most):
        all_ = [
            each for each in candidates(found.structure, effects, found.problem.windows) if each.name not in refused
        ]
        names = {each.name for each in all_}
        asked = float(-ndtri(0.025 / max(len(names), 1)))  # the surest of so many is so by chance in one of twenty
        kept = _promising(found, all_, looked)
        kept += [
            each
            for each in _promising(check, all_, looked)
            if (each.name, each.own) not in {(one.name, one.own) for one in kept}
        ]
        hopeful = []
        for each in kept:
            new, as_told = _with(found, each), _with(check, each)
            if new.value > found.value - 3.0 or as_told.value > check.value - 3.0:
                continue
            evidence = _evidence(each, new, as_told)
            if evidence.sure < asked:
                continue
            if (axis := drives(new)) and not drives(found):
                refused[each.name] = f"with it {axis} drives itself at speeds that were seen"
                continue
            hopeful.append((evidence, each, new, as_told))
        if hopeful:
            base = left_out(found)
            promise = [
                gain_of(base - left_out(new), new.problem.windows).deviations + told.sure for told, _, new, _ in hopeful
            ]
            hopeful = [hopeful[k] for k in np.argsort(-np.array(promise))]
        sound = []
        bases = (left_out(found, True), left_out(check, True)) if hopeful else ()
        for evidence, each, new, as_told in hopeful[:finalists]:
            simulated = gain_of(bases[0] - left_out(new, True), new.problem.windows)
            predicted = gain_of(bases[1] - left_out(as_told, True), as_told.problem.windows)
            evidence = replace(evidence, simulated=simulated, predicted=predicted)
            say(f"      {each.name}: {evidence}")
            if evidence.convinces:
                sound.append((evidence, each, new, as_told))
        if not sound:
            break
        best = max(sound, key=lambda one: one[0].weight)
        equals = [one for one in sound if one[3].value < best[3].value + 5.0 and one[2].value < best[2].value + 5.0]
        evidence, each, new, as_told = min(equals, key=lambda one: rank(one[1].name))
        say(f"   + {each.name}")
        added.append((each.name, evidence))
        alike[each.name] = tuple(
            dict.fromkeys(
                other.name
                for told, other, _, fit_ in hopeful
                if other.name != each.name and fit_.value < as_told.value + 5.0
            )
        )
        found, check = new, as_told
    return Found(found, check, tuple(added), refused, alike)


@dataclass(frozen=True, slots=True)
class Evidence:
    """What speaks for an effect.

    Attributes:
        sure: deviations by which the predictor's coefficient is away from where it does nothing.
        apart: by how much the simulation's coefficient differs, in what the two may differ by.
        simulated, predicted: gains on what was left out.
    """

    sure: float
    apart: float
    simulated: Gain = Gain(0.0, 0.0, 0.0)
    predicted: Gain = Gain(0.0, 0.0, 0.0)

    @property
    def agrees(self) -> bool:
        """Whether simulation and prediction agree on the coefficient."""
        return self.apart <= 1.0

    @property
    def weight(self) -> float:
        """By which the best of several is chosen: deviations of the coefficient and of both gains."""
        return self.sure + self.simulated.deviations + self.predicted.deviations

    @property
    def convinces(self) -> bool:
        """Whether both gain on what was left out, one of them clearly where they agree on the size, else both."""
        gains = (self.simulated, self.predicted)
        clear = sum(each.deviations >= 3.0 and each.agreeing >= 0.75 and each.total > 3.0 for each in gains)
        return min(each.deviations for each in gains) > 0.0 and (
            clear > 0 if self.agrees else clear > 1 and self.apart <= 2.0
        )


def _with(base: Fit, candidate: Candidate, rounds: int = 8) -> Fit:
    """The candidate on top of a base, be it a simulation or a predictor."""
    structure = as_that(candidate.structure, base.structure)
    return fit(structure, {**base.theta, **candidate.start}, base.problem, base.starts, rounds=rounds)


def as_that(structure: Structure, that: Structure) -> Structure:
    """A structure as another estimates: by prediction or not, with its average over a measured effort's noise."""
    blurs = tuple(stage for stage in that.stages if stage[0] == "blur" and stage not in structure.stages)
    return replace(structure, predictor=that.predictor, stages=structure.stages + blurs)


def _evidence(candidate: Candidate, new: Fit, as_told: Fit) -> Evidence:
    name = candidate.own
    at = as_told.names.index(name)
    deviation = float(np.sqrt(covariance(as_told)[at, at]))
    size = 1.0 if is_logarithm(name) else abs(new.theta[name])
    apart = abs(new.theta[name] - as_told.theta[name]) / (2.0 * deviation + 0.1 * size + 1e-300)
    return Evidence(_sureness(as_told, candidate), apart)


def rank(name: str) -> int:
    """Of effects that explain the recordings alike the plainest is named: 0, before those that stand in for many."""
    kind = name.partition("@")[0].partition(":")[0]
    return (
        2 if kind in ("memory", "drag_step", "thrust_step") else 1 if kind in ("coulomb_asymmetry", "modulation") else 0
    )


def drives(found: Fit) -> str:
    """The axis whose damping drives the vehicle at more than one in a hundred of the speeds seen; empty where none does."""
    windows, structure = found.problem.windows, found.structure
    signals = {**windows.velocity, **windows.channel}
    for axis in structure.axes:
        own = windows.velocity[axis]
        moving = np.abs(own) > 0.1 * np.quantile(np.abs(own), 0.9)
        total = np.zeros_like(own)
        for row in structure.rows:
            if row.drag and row.axis == axis and not row.follows:
                total = total + found.theta[row.key] * one_by_one(row.parts[0].one, signals) * one_by_one(
                    row.parts[0].other, signals
                )
        if np.mean((total * own)[moving] < 0.0) > 0.01:
            return axis
    return ""


def _promising(found: Fit, all_: Sequence[Candidate], count: int, screened: int = 8) -> list[Candidate]:
    """The candidates that gain most after two rounds of a fit, of one name the best start.

    Of many rows only some are fitted at all: those whose first step promises most, three times as many as are wanted,
    because a first step misjudges what is large.
    """
    rows = [each for each in all_ if each.rows]
    if len(rows) > screened:
        promised = _first_steps(found, [each.rows for each in rows])
        chosen = {id(rows[k]) for k in np.argsort(-promised)[:screened]}
        all_ = [each for each in all_ if not each.rows or id(each) in chosen]
    if len(all_) <= count:
        return list(all_)
    best: dict[str, tuple[float, Candidate]] = {}
    for each in all_:
        value = found.value - _with(found, each, rounds=2).value
        if each.name not in best or value > best[each.name][0]:
            best[each.name] = (value, each)
    return [each for _, each in sorted(best.values(), key=lambda pair: -pair[0])[:count]]


def _first_steps(found: Fit, groups: Sequence[tuple[Row, ...]]) -> Array:
    """(groups,) what the first step towards the rows of each group would gain, all parameters moving along (Rao's score)."""
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
    name = candidate.own
    kind, _, axis = name.partition(":")
    at_ = new.names.index(name)
    deviation, value_ = float(np.sqrt(spread[at_, at_])), new.theta[name]
    if kind in ("lag", "dead"):  # logarithms: nothing at minus infinity; sure where the interval is narrow
        return 1.0 / max(deviation, 1e-9)
    if kind == "limit":
        top = float(np.log(new.problem.windows.largest(new.structure.effort(axis))))
        return (top - value_) / max(deviation, 1e-9)
    if kind == "shift":  # less than a period is how two clocks sample
        return (abs(value_) - period(new.problem.windows.runs, new.structure.effort(axis))) / max(deviation, 1e-9)
    if kind == "mass" and "*" not in axis:
        return abs(value_ - candidate.start[name]) / max(deviation, 1e-9)
    return abs(value_) / max(deviation, 1e-9)
