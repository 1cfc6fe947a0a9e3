"""A vehicle from recordings: the plain model, C(ν), then the effects that it lacks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.model import rows as catalogue
from incsvr.model.candidates import CURVE, SHAPES, coupled_pairs, of_curve, without
from incsvr.model.efforts import WAYS
from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.left_out import gain, left_out
from incsvr.model.predictor import Predictor, frequencies, predictor
from incsvr.model.rivals import excluded_free_runs
from incsvr.model.rows import Row, free_products, mirrored
from incsvr.model.scales import coarse_period, fastest, motion_scale, step_of, time_constants
from incsvr.model.search import Found, drives, is_clear, search
from incsvr.model.series import duration, effort_of, period, values
from incsvr.model.start import start
from incsvr.model.structure import Structure
from incsvr.model.windows import ANGLES, Windows, cut
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import VELOCITIES

PLAIN, EFFECTS = "plain", "effects"
"""Names of the simulators: without effects, and with those that were found."""


@dataclass(frozen=True)
class Identification:
    """A vehicle, identified.

    Attributes:
        found: the effects that the plain model lacks, as a predictor, which is right in open and in closed loop.
        base: the same without effects, with damping of any shape for one axis.
        effects: that were tried, by name the rows of each.
        reliability: by axis, the share of its effort's variance that is no noise.
        models: simulators, fitted to free courses of windows: `plain`, `effects` where any was found, and both with
            `, free inertia` where any is declared.
        excluded: (axes,) by model, and for `zero` and `hold`, the RMS error of free runs of recordings, or of long
            blocks of one or two, by the fit without them [m/s], [rad/s].
    """

    found: Found
    base: Fit
    effects: Mapping[str, Sequence[Row]]
    reliability: Mapping[str, float]
    models: Mapping[str, Fit]
    excluded: Mapping[str, Array]

    @property
    def best(self) -> str:
        """The name of the simulator with the smallest error of excluded free runs, in shares of a velocity of zero."""
        zero = self.excluded["zero"]
        return min(self.models, key=lambda name: float(np.mean(self.excluded[name] / zero)))

    @property
    def model(self) -> Fit:
        """The best simulator."""
        return self.models[self.best]


def structure_of(
    runs: Sequence[Streams], axes: Sequence[str], channels: Sequence[str] = (), given: Mapping[str, float] | None = None
) -> Structure:
    """The plain structure of some axes: M of a body whose port mirrors its starboard, own damping, restoring, C(M) for
    several; `given` are declared inertias by axis, and entries of M by pair, as `sway*yaw_rate`."""
    driven = tuple(
        axis for axis in axes if all(effort_of(axis) in run for run in runs) and np.any(values(runs, effort_of(axis)))
    )
    recorded = [name for name in ANGLES if all(name in run for run in runs)]
    rows = tuple(row for axis in axes for row in catalogue.damping(axis))
    rows += catalogue.restoring(axes, recorded)
    declared = tuple((a, b) for a, star, b in (name.partition("*") for name in given or {}) if star)
    mirrored = [pair for pair in coupled_pairs(axes) if {*pair} not in [{*one} for one in declared]]
    angles = [name for name in ("roll", "pitch") if name in recorded and {"roll_rate", "pitch_rate"} & set(axes)]
    return Structure(
        tuple(axes), driven, rows, tied=len(axes) > 1,
        coupled=declared + tuple(pair for pair in mirrored if not {*pair} <= {*(given or {})}),
        given={name: float(value if "*" in name else np.log(value)) for name, value in (given or {}).items()},
        shift_priors={axis: 0.5 * period(runs, effort_of(axis)) for axis in driven},
        channels=tuple(dict.fromkeys((*channels, *angles))),
    )  # fmt: skip


def plain_fit(
    structure: Structure,
    runs: Sequence[Streams],
    constants: float = 3.0,  # of the slowest axis in a window, so that damping and inertia both show in it
    fewest: float = 24.0,  # windows: with fewer neither folds nor blocks show the error of an estimate
) -> Fit:
    """The plain model; step and horizon follow its time constants, and the efforts' way between samples fits best."""
    theta = start(structure, runs)
    length = duration(runs, structure.axes[0])
    fast, slow = fastest(structure, theta, runs), time_constants(structure, theta, runs, 0.5)
    for turn in range(3):
        step = step_of(coarse_period(runs, structure.axes, fast), fast)
        horizon = min(constants * float(slow.max()), length / fewest)
        problem = Problem(cut(runs, structure, step, horizon))
        begin: Array | None = None
        if turn == 0:
            tried = [
                fit(replace(structure, ways=dict.fromkeys(structure.driven, way)), theta, problem, rounds=5)
                for way in WAYS
            ]
            best = min(tried, key=lambda each: each.value)
            structure, theta, begin = best.structure, dict(best.theta), best.starts
        found = fit(structure, theta, problem, begin)
        theta = dict(found.theta)
        fast, slow = fastest(structure, theta, runs), time_constants(structure, theta, runs, 0.5)
        near = 0.7 < step_of(coarse_period(runs, structure.axes, fast), fast) / step < 1.5
        wanted = min(constants * float(slow.max()), length / fewest)
        if near and 0.6 < wanted / horizon < 1.7:
            break
    return found


def pool(structure: Structure, runs: Sequence[Streams], instants: int = 20) -> dict[str, tuple[Row, ...]]:
    """The effects that a structure may lack on each of its axes, by name the rows of each.

    Args:
        instants: tried for a jump of damping or thrust, evenly over the recordings.
    """
    names = set.intersection(*(set(run) for run in runs))
    velocities = catalogue.recorded_velocities(tuple(names))
    single = len(structure.axes) == 1
    rows: list[Row] = []
    found: dict[str, tuple[Row, ...]] = {}
    for axis in structure.axes:
        driven = axis in structure.driven
        fast = float(np.quantile(np.abs(values(runs, axis)), 0.99))
        rows += catalogue.own(axis, fast, driven)
        others = [name for name in velocities if name != axis]
        usual = {name: float(np.mean(np.abs(values(runs, name)))) for name in others}
        rows += catalogue.with_others(axis, others, driven, usual if single and axis in structure.given else None)
        if not single:
            rows += catalogue.efforts_of_others(axis, structure.driven)
            continue
        if axis == "yaw_rate" and "heading" in structure.channels:
            found |= catalogue.turned(axis)
        if "time" in structure.channels:
            span = values(runs, "time")
            at = np.linspace(span.min(), span.max(), instants + 2)[1:-1]
            found |= catalogue.of_time(axis, at.tolist(), driven)
        for name in structure.channels:
            if name not in (*VELOCITIES, *ANGLES, "time"):
                rows += catalogue.of_channel(axis, name, float(np.mean(values(runs, name))), driven)
        scale = motion_scale(runs, axis)
        beat = period(runs, axis)
        rows.append(catalogue.memory(axis, tuple(max(times * scale, 2.0 * beat) for times in (0.5, 1.0, 6.0))))
    known = {row.key for row in catalogue.free_products(structure.axes)} if structure.tied else set()  # C(M) has them
    return {row.key: (row,) for row in rows if mirrored(row) and row.key not in known} | found


def identify(
    runs: Sequence[Streams],
    axes: Sequence[str],
    given: Mapping[str, float] | None = None,
    channels: Sequence[str] = (),
    most: int = 6,  # of a dozen vehicles none had more effects
    *,
    leave: Sequence[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> Identification:
    """The plain model of some axes, and the one with the effects that it lacks.

    Args:
        runs: the recordings.
        axes: velocities that the model predicts.
        given: declared inertias by axis [kg], [kg m²], and entries of M by pair, as `sway*yaw_rate`.
        channels: other streams that may act on an axis.
        most: effects that may be added.
        leave: effects, without what is behind their colon, that are not tried.
        say: takes a line for each decision.
    """
    names = set.intersection(*(set(run) for run in runs))
    others = tuple(name for name in VELOCITIES if name in names and name not in axes) + tuple(channels)
    plain = found = plain_fit(structure_of(runs, axes, others, given), runs)
    windows = plain.problem.windows
    say(
        f"plain: step {windows.step:.3g} s, {windows.first.size} windows of {windows.steps * windows.step:.3g} s, "
        f"efforts {dict(plain.structure.ways)}, cost {plain.value:.0f}"
    )
    if len(axes) > 1:
        plain, found = choose_coriolis(plain, runs, say=say)
    base = predictor(_with_curve(found, runs) if len(axes) == 1 else found, runs)
    say(f"predictor: step {base.fit.problem.windows.step:.3g} s, cost {base.fit.value:.0f}, {base.reliability}")
    effects = pool(plain.structure, base.fit.problem.windows.runs)
    if len(axes) == 1:
        effects |= catalogue.curves(axes[0], _fast(found, runs))
    if len(axes) == 1 and "time" in plain.structure.channels:
        effects |= catalogue.waves(axes[0], frequencies(base.fit, 0))
    if list(axes) == ["yaw_rate"] and "heading" not in names:  # a heading shows a gyro's zero by itself
        effects |= catalogue.gyro_zero(axes[0], *(found.theta[f"{name}@{axes[0]}"] for name in ("linear", "quadratic")))
    effects = {name: rows for name, rows in effects.items() if name.partition("@")[0].partition(":")[0] not in leave}
    untried = {f"{name}@{axis}": "it is not tried" for name in leave for axis in axes}
    result = search(base, effects, most, begun=Found(base.fit, refused=untried), say=say)
    acting = base.fit.problem.windows.runs
    if any(share < 1.0 for share in base.reliability.values()):  # the noise of an effort never acts
        found = plain_fit(found.structure, acting)
    alone = base.fit
    if len(axes) == 1:
        found, alone, result = _with_curve_found(found, alone, result)
    models = _simulators(found, result)
    excluded = excluded_free_runs(models, acting)
    say(f"free runs of excluded recordings: {excluded}")
    return Identification(result, alone, effects, base.reliability, models, excluded)


def leaving(found: Identification, names: Mapping[str, str], more: bool) -> Identification:
    """The identification without some of its effects, by name why; what remains is fitted anew.

    Args:
        more: whether the search goes on without them, as it may where free runs judge what it adds.
    """
    was = found.found
    kept = tuple(each for each in was.added if each.name not in names)
    because = {name: why for name, why in was.refused.items() if not any(one in why for one in names)}
    begun = Found(remaining(found, names), kept, {**because, **names})
    result, plain, base = begun, found.models[PLAIN], found.base
    if more:
        result = search(Predictor(base, found.reliability), found.effects, begun=begun)
        plain, base, result = _with_curve_found(plain, base, result)
    models = _simulators(plain, result)
    return replace(
        found, found=result, base=base, models=models, excluded=excluded_free_runs(models, was.fit.problem.windows.runs)
    )


def remaining(found: Identification, names: Collection[str]) -> Fit:
    """The predictor without some of its effects, fitted anew."""
    was, structure, theta = found.found, found.found.fit.structure, dict(found.found.fit.theta)
    for each in was.added:
        if each.name in names:
            structure = without(structure, each.candidate, found.base.structure)
            theta |= {name: found.base.theta[name] for name in each.candidate.start if name in found.base.theta}
        else:
            theta |= each.candidate.start  # before what leaves had moved it
    return fit(structure, theta, was.fit.problem, was.fit.starts)


def _fast(plain: Fit, runs: Sequence[Streams]) -> float:
    """A velocity of the first axis that is seldom passed [m/s], [rad/s]."""
    return float(np.quantile(np.abs(values(runs, plain.structure.axes[0])), 0.99))


def _with_curve(plain: Fit, runs: Sequence[Streams]) -> Fit:
    """The plain model of one axis with damping of any shape, so that the shape does not pass for an effect."""
    (axis,) = plain.structure.axes
    more = plain.structure.plus(rows=catalogue.bends(axis, _fast(plain, runs)))
    return fit(more, {**dict.fromkeys(more.names, 0.0), **plain.theta}, plain.problem, plain.starts)


def _with_curve_found(plain: Fit, base: Fit, found: Found) -> tuple[Fit, Fit, Found]:
    """The plain model, the predictor without effects and the result, each with the curve of damping that the search
    added: it is part of the learned damping and no effect."""
    rows = [row for each in found.added if of_curve(each.candidate) for row in each.candidate.rows]
    effects = tuple(each for each in found.added if not of_curve(each.candidate))
    weighed = tuple(one for one in found.weighed if not of_curve(one[0]))
    if rows:
        plain, base = (
            fit(each.structure.plus(rows=rows), {**each.theta, **dict.fromkeys((row.key for row in rows), 0.0)},
                each.problem, each.starts)
            for each in (plain, base)
        )  # fmt: skip
    refused = {name: why for name, why in found.refused.items() if not name.startswith(CURVE)}
    return plain, base, Found(found.fit, effects, refused, weighed)


def _simulators(plain: Fit, found: Found) -> dict[str, Fit]:
    """The plain model and that with effects, as simulators, with the inertia declared and free."""
    models = {PLAIN: plain}
    if found.added:
        runs, own = found.fit.problem.windows.runs, replace(found.fit.structure, predictor=False)
        new = {name: found.fit.theta[name] for name in own.names}
        starts = (new, {**new, **{name: value for name, value in plain.theta.items() if name in new}})
        trials = []
        for way in WAYS:  # without its effects the model had hidden the way
            structure = replace(own, ways=dict.fromkeys(own.driven, way))
            problem = Problem(_as_cut(plain, runs, structure))
            trials += [fit(structure, each, problem) for each in starts]
        models[EFFECTS] = min(trials, key=lambda each: each.value)
    for name, model in list(models.items()):
        given = model.structure.given
        if given:
            free = {f"mass:{axis}": value for axis, value in given.items()}
            structure = replace(model.structure, given={})
            models[f"{name}, free inertia"] = fit(structure, {**model.theta, **free}, model.problem, model.starts)
    return models


def _as_cut(model: Fit, runs: Sequence[Streams], structure: Structure) -> Windows:
    """Recordings cut as those of a fit."""
    windows = model.problem.windows
    return cut(runs, structure, windows.step, windows.step * windows.steps)


def choose_coriolis(
    plain: Fit,
    runs: Sequence[Streams],
    enough: float = 12.0,  # of the logarithm of the likelihood, as of an effect
    agreeing: float = 0.875,  # of the folds, more than of an effect, because C(M) is the hypothesis
    *,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Fit, Fit]:
    """The plain model with C(ν) of M, from the best start, and the one that excluded recordings decide for.

    C(M) is the hypothesis: products with coefficients of their own, or none, replace it only where they win clearly.
    """
    free = replace(plain.structure, tied=False).plus(rows=free_products(plain.structure.axes))
    theta = {**start(free, runs), **{name: value for name, value in plain.theta.items() if name.startswith("shift")}}
    rival = fit(free, theta, plain.problem, plain.starts)
    of_rival = {name: rival.theta.get(name, value) for name, value in plain.theta.items()}
    again = fit(plain.structure, of_rival, plain.problem, rival.starts)
    # The other start, so that no local minimum decides; excluded recordings, so that none that diverges there is taken.
    plain = best = min(plain, again, key=lambda each: float(left_out(each).sum()))
    base = left_out(plain)
    without = replace(plain.structure, tied=False)
    rivals = {
        "free products": rival,
        "no C(ν)": fit(without, start(without, runs), plain.problem, plain.starts),
    }
    for label, other in rivals.items():
        reached = gain(base - left_out(other), plain.problem.windows)
        say(f"{label} in place of C(M): {reached}")
        if is_clear(reached, enough, agreeing) and other.value < best.value and not drives(other):
            best = other
    return plain, best


def crossed(found: Fit) -> Fit:
    """The model with linear damping between the axes of a mirrored body, as far as it does not have it."""
    known = {row.key for row in found.structure.rows}
    rows = [row for row in catalogue.cross_damping(coupled_pairs(found.structure.axes)) if row.key not in known]
    if not rows:
        return found
    theta = {**dict.fromkeys((row.key for row in rows), 0.0), **found.theta}
    return fit(found.structure.plus(rows=rows), theta, found.problem, found.starts)


def reshaped(found: Fit) -> Fit:
    """The model with each lag in its other shape: of the thrust, or of the rotors' speed."""
    other = {kind: SHAPES[kind] for kind in ("lag", "spin")}
    lags = {f"{kind}:{axis}": f"{other[kind]}:{axis}" for kind, axis in found.structure.stages if kind in other}
    if not lags:
        return found
    stages = tuple((other.get(kind, kind), axis) for kind, axis in found.structure.stages)
    theta = {lags.get(name, name): value for name, value in found.theta.items()}
    return fit(replace(found.structure, stages=stages), theta, found.problem, found.starts)
