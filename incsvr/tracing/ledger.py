"""What each part of a model takes of the torque at the edges of its windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.fitting import Fit
from incsvr.model.series import effort_of
from incsvr.numerics import Array
from incsvr.tracing.model import TracedModel, parts
from incsvr.tracing.traced_model import damping_of


def ledger_of(model: Fit, traced: TracedModel) -> tuple[Array, dict[str, Array]]:
    """(n,) stamps [s], and by part the torque that it takes there [N m]: inertia, damping, effects by their names.

    Args:
        traced: the same model with its effects by name.
    """
    course, windows, structure = model.course, model.problem.windows, model.structure
    axis = traced.axis
    inside = np.arange(windows.steps)[:, None] < windows.count
    grids = [windows.grids[run] for run in windows.run]
    begin = np.array([grid.origin for grid in grids]) + windows.step * (windows.first - [grid.first for grid in grids])
    stamps = begin + windows.step * np.arange(windows.steps)[:, None]
    motion = course.motion
    signals = {name: course.states[:-1, k] for k, name in enumerate(motion.states)}
    signals |= {name: motion.edges[:-1, k] for k, name in enumerate(motion.channels)}
    aligned = 0.0 if f"shift:{axis}" in traced.theta else model.theta.get(f"shift:{axis}", 0.0)

    def effort(stage: Stage) -> Array:
        way = structure.ways.get(axis, "linear")
        return windows.effort(axis, way, replace(stage, shift=stage.shift + aligned))

    found = {"declared inertia": traced.inertia * course.slopes[:, 0], "damping": damping_of(model, signals[axis])}
    more = structure.inertia(model.theta, axis) - traced.inertia
    if abs(more) > 1e-9 * traced.inertia:
        found["inertia"] = more * course.slopes[:, 0]
    if effort_of(axis) in windows.runs[0]:
        found |= parts(traced.effects, axis, signals, effort)
    order = np.argsort(stamps[inside], kind="stable")
    return stamps[inside][order], {name: each[inside][order] for name, each in found.items()}
