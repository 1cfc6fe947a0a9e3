"""What each part of a model takes of the torque at the edges of its windows."""

from __future__ import annotations

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit
from incsvr.model.series import effort_of
from incsvr.model_trace.vocabulary import contract_name
from incsvr.numerics import Array

OWN = ("linear", "quadratic", "bend")


def ledger_of(model: Fit, inertia: float) -> tuple[Array, dict[str, Array]]:
    """(n,) stamps [s], and by part the torque that it takes there [N m]: inertia, damping, effects by their names.

    Stages of the effort are one part, `actuators`: the command less what acts.

    Args:
        inertia: declared; what the model's is more is the part `inertia`.
    """
    course, windows, structure = model.course, model.problem.windows, model.structure
    (axis,) = structure.axes
    inside = np.arange(windows.steps)[:, None] < windows.count
    grids = [windows.grids[run] for run in windows.run]
    begin = np.array([grid.origin for grid in grids]) + windows.step * (windows.first - [grid.first for grid in grids])
    stamps = begin + windows.step * np.arange(windows.steps)[:, None]
    motion = course.motion
    signals = {name: course.states[:-1, k] for k, name in enumerate(motion.states)}
    signals |= {name: motion.edges[:-1, k] for k, name in enumerate(motion.channels)}
    acting = motion.efforts[:, 0, 0] if structure.driven else np.zeros_like(stamps)
    signals[effort_of(axis)] = acting
    more = structure.inertia(model.theta, axis) - inertia
    parts = {"declared inertia": inertia * course.slopes[:, 0], "damping": np.zeros_like(stamps)}
    if abs(more) > 1e-9 * inertia:
        parts["inertia"] = more * course.slopes[:, 0]
    for row in structure.rows:
        part = row.parts[0]
        taken = model.theta[row.key] * one_by_one(part.one, signals) * one_by_one(part.other, signals)
        name = "damping" if row.name.partition(":")[0] in OWN else contract_name(row.key)
        parts[name] = parts.get(name, 0.0) + taken
    if structure.stages:
        way = structure.ways.get(axis, "linear")
        parts["actuators"] = windows.effort(axis, way, Stage()) - acting
    order = np.argsort(stamps[inside], kind="stable")
    return stamps[inside][order], {name: each[inside][order] for name, each in parts.items()}
