"""The search for what a model lacks: one candidate at a time, each fitted with all the rest, judged where it was left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import ndtri

from incsvr.model.efforts import Stage
from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit, fit, slopes_of, unit
from incsvr.model.intervals import DEVIATIONS_OF_95, deviations
from incsvr.model.left_out import Gain, gain, left_out, gain_of
from incsvr.model.rows import Row
from incsvr.model.series import values
from incsvr.model.structure import Structure
from incsvr.model.windows import Windows
from incsvr.numerics import Array


@dataclass(frozen=True)
class Candidate:
    """Something that a model may lack.

    Attributes:
        name: the effect.
        structure: the model with it.
        start: parameters that it brings, and where their fit begins.
    """

    name: str
    structure: Structure
    start: Mapping[str, float]


@dataclass(frozen=True)
class Found:
    """What a search ended with.

    Attributes:
        fit: the model.
        added: names, in the order in which they were added, with the gain of each.
        refused: names, with the reason.
    """

    fit: Fit
    added: tuple[tuple[str, Gain], ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)


def candidates(structure: Structure, rows: Sequence[Row], windows: Windows) -> list[Candidate]:
    """Each row, stage of an effort, delay, coupled inertia and free inertia that the structure does not have."""
    have = {row.key for row in structure.rows}
    found = []
    for row in rows:
        if row.key in have:
            continue
        more = structure.plus(rows=[row])
        if not row.follows:
            found.append(Candidate(row.key, more, {row.key: 0.0}))
        else:
            found += [
                Candidate(row.key, more, {row.key: 0.0, f"time:{row.key}": float(np.log(lag))}) for lag in row.lags
            ]
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
                found += [Candidate(f"{kind}@{axis}", more, {f"{kind}:{axis}": float(at)}) for at in each]
        if structure.shift_priors.get(axis, np.inf) < 1e3:
            wide = replace(structure, shift_priors={**structure.shift_priors, axis: 1e6})
            found += [Candidate(f"delay@{axis}", wide, {f"shift:{axis}": 2.0 * windows.step})]
        if axis in structure.given:
            found.append(Candidate(f"inertia@{axis}", structure.plus(free=[axis]), {f"mass:{axis}": structure.given[axis]}))
    return found


def search(
    found: Fit,
    rows: Sequence[Row],
    price: float | None = None,
    most: int = 6,
    looked: int = 10,
    finalists: int = 3,
    least: float = 0.1,
    log=None,
) -> Found:
    """Adds candidates one at a time, while the best is surer than chance makes the best of so many in one of twenty.

    Args:
        rows: those that may be added.
        price: deviations that a coefficient must be away from zero; None for that of chance.
        most: are added.
        finalists: candidates whose folds are fitted anew.
        looked: candidates that are fitted in full a round, the most promising of all after one step each.
        least: a name needs a size: RMS of what the row takes, in the RMS of the errors without it.
    """
    added, refused = list[tuple[str, Gain]](), dict[str, str]()
    for _ in range(most):
        all_ = [each for each in candidates(found.structure, rows, found.problem.windows) if each.name not in refused]
        asked = price or float(-ndtri(0.025 / max(len(all_), 1)))
        base = left_out(found)
        promising = _promising(found, all_, looked, base)
        hopeful = []
        for each in promising:
            new = fit(each.structure, {**found.theta, **each.start}, found.problem, found.starts, rounds=8)
            reached, sure = gain_of(base - left_out(new), found.problem.windows), _sureness(new, each)
            if log: log(f"      {each.name}: gain {reached.total:.0f} dev {reached.deviations:.1f} agree {reached.agreeing:.2f} sure {sure:.1f}")
            if sure < asked or new.value > found.value - 3.0:
                continue
            if (axis := drives(new)) and not drives(found):
                refused[each.name] = f"with it {axis} drives itself at speeds that were seen"
                continue
            hopeful.append((reached.total, each, new))
        best: tuple[float, str, Gain, Fit] | None = None
        exact = left_out(found, exact=True) if hopeful else base
        for _, each, new in sorted(hopeful, key=lambda one: -one[0])[:finalists]:
            reached = gain_of(exact - left_out(new, exact=True), found.problem.windows)
            if log: log(f"      exact {each.name}: gain {reached.total:.0f} dev {reached.deviations:.1f} agree {reached.agreeing:.2f}")
            if reached.total > 3.0 and reached.deviations >= 1.0 and reached.agreeing > 0.5 and (best is None or reached.total > best[0]):
                best = (reached.total, each.name, reached, new)
        if best is None:
            break
        _, name, reached, new = best
        again = fit(found.structure, {k: new.theta.get(k, v) for k, v in found.theta.items()}, found.problem, new.starts)
        if again.value < found.value - 1.0:  # it only showed the way out of a local minimum: look again from there
            if log: log(f"   (from {name}: a better minimum, {found.value:.0f} to {again.value:.0f})")
            found = again
            continue
        if log: log(f"   + {name}: gain {reached.total:.0f} ({reached.deviations:.1f})")
        found = new
        added.append((name, reached))
    return Found(found, tuple(added), refused)


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
                total = total + found.theta[row.key] * one_by_one(row.parts[0].one, signals) * one_by_one(row.parts[0].other, signals)
        if np.mean((total * own)[moving] < 0.0) > 0.01:
            return axis
    return ""


def _promising(found: Fit, all_: Sequence[Candidate], count: int, base: Array, screened: int = 12) -> list[Candidate]:
    """The candidates that gain most after two rounds of a fit, of one name the best start.

    Of many rows only some are fitted at all: those whose first step promises most, three times as many as are wanted,
    because a first step misjudges what is large.
    """
    rows = [each for each in all_ if len(each.start) == 1 and next(iter(each.start)) == each.name and "*" not in each.name[:5]]
    if len(rows) > screened:
        promised = _first_steps(found, [each.structure.rows[-1] for each in rows])
        chosen = {rows[k].name for k in np.argsort(-promised)[:screened]}
        all_ = [each for each in all_ if each not in rows or each.name in chosen]
    if len(all_) <= count:
        return list(all_)
    best: dict[str, tuple[float, Candidate]] = {}
    for each in all_:
        new = fit(each.structure, {**found.theta, **each.start}, found.problem, found.starts, rounds=2)
        value = float(np.sum(base - new.cost))
        if each.name not in best or value > best[each.name][0]:
            best[each.name] = (value, each)
    return [each for _, each in sorted(best.values(), key=lambda pair: -pair[0])[:count]]


def _first_steps(found: Fit, rows: Sequence[Row]) -> Array:
    """(rows,) what the first step towards each row would gain, all parameters moving along (Rao's score statistic)."""
    more = found.structure.plus(rows=rows)
    units = np.array([unit(name, more, found.theta, found.problem.windows) for name in more.names])
    theta = {**{row.key: 0.0 for row in rows}, **found.theta}
    point = np.array([theta[name] for name in more.names])
    state = slopes_of(more, point, found.problem, found.starts, found.scale, units)
    new = np.array([name in {row.key for row in rows} for name in more.names])
    normal, slope = state.normal.sum(axis=0), state.gradient.sum(axis=0)
    normal += 1e-9 * np.diag(np.diag(normal))
    across = np.linalg.solve(normal[np.ix_(~new, ~new)] + np.diag(found.prior), normal[np.ix_(~new, new)])
    rest = slope[new] - across.T @ slope[~new]
    size = np.diag(normal)[new] - np.einsum("ij,ij->j", normal[np.ix_(~new, new)], across)
    gain_ = 0.5 * rest**2 / np.maximum(size, 1e-12 * np.diag(normal)[new])
    order = [name for name in more.names if name in {row.key for row in rows}]
    by_name = dict(zip(order, gain_, strict=True))
    forbidden = {name for name, step in zip(order, rest, strict=True) for row in rows if row.key == name and step < 0.0 <= row.low}
    return np.array([0.0 if row.key in forbidden else by_name[row.key] for row in rows])


def _sureness(new: Fit, candidate: Candidate) -> float:
    """How many deviations the candidate's own parameter is away from where it does nothing."""
    name = next(iter(candidate.start))
    kind, _, axis = name.partition(":")
    deviation = float(deviations(new)[new.names.index(name)])
    at = new.theta[name]
    if kind in ("lag", "dead", "time"):  # logarithms: nothing at minus infinity; sure where the interval ends above zero
        return 1.0 / max(deviation, 1e-9)
    if kind == "limit":
        top = np.log(new.problem.windows.largest(new.structure.effort(axis)))
        return (top - at) / max(deviation, 1e-9)
    if kind == "mass" and "*" not in axis:
        return abs(at - candidate.start[name]) / max(deviation, 1e-9)
    return abs(at) / max(deviation, 1e-9)
