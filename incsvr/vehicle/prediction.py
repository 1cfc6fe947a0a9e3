"""Errors of a vehicle's model on data that its fit excluded: seconds ahead, in free run, of each axis by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.left_out import fold_parameters, folds
from incsvr.model.rows import Row, free_products, row, value
from incsvr.model.series import between
from incsvr.model.simulation import simulate
from incsvr.model.structure import Structure
from incsvr.model.windows import Windows, cut
from incsvr.numerics import Array, Streams, root_mean_square
from incsvr.plant.axes import AXES, VELOCITIES, of_rate

HORIZONS_S = (1.0, 5.0, 20.0)
"""The horizons at which predictions are judged [s]."""
RUNAWAY = 1e3
"""A speed beyond which an error is not counted [m/s], [rad/s]: that of a model that runs away is infinite."""


@dataclass(frozen=True, slots=True)
class Errors:
    """RMS errors of predictions.

    Attributes:
        axes: names of the axes that are predicted.
        horizons: seconds ahead → errors of the model, of the first velocity kept, and of zero, (axes,) each.
        free_run, hold, zero: (axes,) the same over whole recordings.
        track: seconds ahead → RMS distance [m] between the predicted track and that of the measured velocities; empty
            where surge or yaw rate is not recorded.
    """

    axes: tuple[str, ...]
    horizons: Mapping[float, tuple[Array, Array, Array]]
    free_run: Array
    hold: Array
    zero: Array
    track: Mapping[float, float]

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data."""

        def table(errors: Sequence[Array]) -> dict[str, dict[str, float]]:
            rows = zip(self.axes, *(each.tolist() for each in errors), strict=True)
            return {axis: {"model": m, "hold": h, "zero": z} for axis, m, h, z in rows}

        return {
            "horizons": {f"{seconds:g}": table(errors) for seconds, errors in self.horizons.items()},
            "whole_runs": table((self.free_run, self.hold, self.zero)) if self.axes else {},
            "track_m": {f"{seconds:g}": error for seconds, error in self.track.items()},
        }


@dataclass(frozen=True, slots=True)
class Course:
    """A free run of all axes beside what was measured.

    Attributes:
        axes: names of the axes.
        time: (n,) since the run began [s].
        measured, simulated: (n, axes) velocities [m/s], [rad/s].
    """

    axes: tuple[str, ...]
    time: Array
    measured: Array
    simulated: Array


NO_ERRORS = Errors((), {}, np.empty(0), np.empty(0), np.empty(0), {})
"""Errors of a model that was not asked to predict."""
Unseen = Sequence[tuple[Array, list[Streams]]]
"""Parameters, and the recordings that their fit excluded."""


def unseen_parts(model: Fit, runs: Sequence[Streams] | None) -> Unseen:
    """Other recordings for a model; without these each part of its own, for the fit without it."""
    if runs:
        return [(np.array([model.theta[name] for name in model.names]), list(runs))]
    windows = model.problem.windows
    fold, columns = folds(windows), fold_parameters(model)
    return [(columns[:, j], _of_fold(windows, fold == k)) for j, k in enumerate(np.unique(fold))]


def _of_fold(windows: Windows, own: Array) -> list[Streams]:
    """The recordings during some windows, which follow each other."""
    found = list[Streams]()
    for which in np.unique(windows.run[own]).tolist():
        inside, grid = own & (windows.run == which), windows.grids[which]
        first, last = windows.first[inside][0] - grid.first, (windows.first + windows.count)[inside][-1] - grid.first
        ends = (grid.origin + windows.step * first, grid.origin + windows.step * last)
        found.append({name: between(stream, *ends) for name, stream in windows.runs[which].items()})
    return found


def errors(structure: Structure, unseen: Unseen, step: float) -> tuple[Errors, Course]:
    """The errors of a model, and its longest free run.

    Args:
        step: of the simulation [s].
    """
    horizons, track = {}, {}
    planar = {"surge", "yaw_rate"} <= set(structure.axes)
    for seconds in HORIZONS_S:
        if sum(_length(run) for _, runs in unseen for run in runs) < seconds:
            continue
        courses = [each for part in unseen for each in _courses(structure, *part, step, seconds)]
        whole = [each for each in courses if each[0].shape[0] > 0.9 * seconds / step]
        if not whole:
            continue
        ends = [
            (simulated[-1] - measured[-1], measured[0] - measured[-1], measured[-1]) for simulated, measured in whole
        ]
        horizons[seconds] = _sizes(ends)
        if planar:
            apart = [_place(s, structure.axes, step)[-1] - _place(m, structure.axes, step)[-1] for s, m in whole]
            track[seconds] = root_mean_square(np.hypot(*np.array(apart).T))
    free = [each for part in unseen for each in _courses(structure, *part, step, np.inf)]
    model, hold, zero = _sizes([(s - m, m[0] - m, m) for s, m in free])
    simulated, measured = max(free, key=lambda each: each[0].shape[0])
    names = tuple(of_rate(axis).name for axis in structure.axes)
    course = Course(names, np.asarray(step * np.arange(simulated.shape[0]), dtype=np.float64), measured, simulated)
    return Errors(names, horizons, model, hold, zero, track), course


def alone(model: Fit, axis: str) -> Fit:
    """One axis by itself, the others' velocities as measured: its own rows, inertia and stages, and the products of
    velocities of C(ν) ν along it, free."""
    whole, problem = model.structure, model.problem
    others = tuple(name for name in VELOCITIES if name in whole.axes and name != axis)
    rows = tuple(_part(each, axis) for each in whole.rows if any(part.axis == axis for part in each.parts))
    more = [each for each in free_products(whole.axes) if each.axis == axis]
    more += [row(f"square:{a}", axis, value(a), value(a)) for a, b in of_rate(axis).products if a == b and a in others]
    keys = {each.key for each in rows}
    rows += tuple(each for each in more if whole.tied and each.key not in keys)
    channels = dict.fromkeys((*others, *whole.channels))
    efforts = {name for each in rows for part in each.parts for name in (part.one.of, part.other.of)}
    channels |= {
        name: None for name in (AXES[of_rate(a).name].effort for a in whole.driven if a != axis) if name in efforts
    }
    structure = replace(
        whole, axes=(axis,), driven=tuple(a for a in whole.driven if a == axis), rows=rows, tied=False, coupled=(),
        given=_given(whole, model, axis), channels=tuple(channels),
        stages=tuple((kind, of) for kind, of in whole.stages if of == axis),
    )  # fmt: skip
    windows = cut(problem.windows.runs, structure, problem.windows.step, problem.windows.step * problem.windows.steps)
    theta = {name: model.theta.get(name, 0.0) for name in structure.names}
    return fit(structure, theta, Problem(windows))


def _given(whole: Structure, model: Fit, axis: str) -> dict[str, float]:
    """The inertia of an axis that nothing drives, by which all its numbers would scale, or that is declared."""
    if axis in whole.given or axis not in whole.driven:
        return {axis: float(np.log(whole.inertia(model.theta, axis)))}
    return {}


def _part(each: Row, axis: str) -> Row:
    return replace(each, parts=tuple(part for part in each.parts if part.axis == axis))


def _length(run: Streams) -> float:
    """How long all streams last [s]."""
    return min(float(t[-1]) for t, _ in run.values()) - max(float(t[0]) for t, _ in run.values())


def _courses(
    structure: Structure, point: Array, runs: Sequence[Streams], step: float, horizon: float
) -> list[tuple[Array, Array]]:
    """The simulated and measured velocities on each window's edges, (edges, axes) each."""
    found = []
    for run in runs:
        if _length(run) < 2.0 * step:
            continue
        windows = cut([run], structure, step, min(horizon, _length(run)))
        states = simulate(structure, point, windows, windows.starts).states
        measured = np.stack([windows.velocity[axis][windows.at] for axis in structure.axes], axis=1)
        for w, count in enumerate(windows.count.tolist()):
            simulated = np.clip(states[: count + 1, : len(structure.axes), w], -RUNAWAY, RUNAWAY)
            found.append((np.nan_to_num(simulated, nan=RUNAWAY), measured[: count + 1, :, w]))
    return found


def _sizes(errors_of: Sequence[Any]) -> tuple[Array, Array, Array]:
    """(axes,) RMS of the errors of the model, of the first velocity kept, and of zero."""
    columns = zip(*errors_of, strict=True)
    model, hold, zero = (
        np.sqrt(np.mean(np.concatenate([np.atleast_2d(e) for e in each]) ** 2, axis=0)) for each in columns
    )
    return model, hold, zero


def _place(course: Array, axes: Sequence[str], step: float) -> Array:
    """North and east (edges, 2) [m] of a course (edges, axes) in a horizontal plane, from its origin, heading 0."""
    u, r = course[:, axes.index("surge")], course[:, axes.index("yaw_rate")]
    v = course[:, axes.index("sway")] if "sway" in axes else np.zeros_like(u)
    heading = np.concatenate(([0.0], np.cumsum(0.5 * step * (r[1:] + r[:-1]))))
    cos, sin = np.cos(heading), np.sin(heading)
    speed = np.stack([cos * u - sin * v, sin * u + cos * v], axis=1)
    return np.concatenate((np.zeros((1, 2)), np.cumsum(0.5 * step * (speed[1:] + speed[:-1]), axis=0)))
