"""The errors of a vehicle's model on recordings: all axes at once, seconds ahead and in free run, and the track."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import AXES
from incsvr.plant.terms import PRODUCT, SQUARE, Term
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.simulation import simulate
from incsvr.vehicle.structure import Structure

HORIZONS_S = (1.0, 5.0, 20.0)
"""The horizons at which predictions are judged [s]."""


@dataclass(frozen=True, slots=True)
class Errors:
    """RMS errors of predictions of one motion.

    Attributes:
        axes: names of the axes that are predicted.
        horizons: seconds ahead → errors of the model, of holding the first velocity, and of zero, (axes,) each.
        free_run: (axes,) over whole runs.
        zero: (axes,) RMS of the measured velocities over whole runs.
        track: seconds ahead → RMS distance [m] between the predicted track and that of the measured velocities; empty
            where surge or yaw rate is not recorded.
    """

    axes: tuple[str, ...]
    horizons: Mapping[float, tuple[Array, Array, Array]]
    free_run: Array
    zero: Array
    track: Mapping[float, float]

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data."""
        return {
            "horizons": {
                f"{seconds:g}": {
                    axis: {"model": float(m), "hold": float(h), "zero": float(z)}
                    for axis, m, h, z in zip(self.axes, *errors, strict=True)
                }
                for seconds, errors in self.horizons.items()
            },
            "whole_runs": {
                axis: {"model": float(m), "zero": float(z)}
                for axis, m, z in zip(self.axes, self.free_run, self.zero, strict=True)
            },
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


NO_ERRORS = Errors((), {}, np.empty(0), np.empty(0), {})
"""Errors of a model that was not asked to predict."""


def errors(structure: Structure, parameters: Array, motion: WholeMotion) -> Errors:
    """The errors of a model with parameters (size,) on a motion that it was not fitted to."""
    rows = structure.rows
    horizons, track = {}, {}
    for seconds in HORIZONS_S:
        cells = max(1, round(seconds / motion.step))
        first = motion.windows(cells)
        if first.size == 0:
            continue
        course = simulate(structure, parameters[None], motion, first, cells)[:, 0]
        measured = np.stack([motion.velocity[first + k] for k in range(cells + 1)])
        end = measured[-1]
        horizons[seconds] = (
            _rms((course[-1] - end)[:, rows]), _rms((measured[0] - end)[:, rows]), _rms(end[:, rows])
        )  # fmt: skip
        if {"surge", "yaw_rate"} <= motion.recorded:
            apart = place(course, motion.step)[-1] - place(measured, motion.step)[-1]
            track[seconds] = root_mean_square(np.hypot(apart[:, 0], apart[:, 1]))
    free, measured_free = _free_run(structure, parameters, motion)
    return Errors(structure.axes, horizons, _rms(free), _rms(measured_free), track)


def place(course: Array, step: float) -> Array:
    """North and east (cells + 1, windows, 2) of courses of ν (cells + 1, windows, 6) in the horizontal plane [m], which
    begin at the origin with heading zero."""
    heading = np.zeros(course.shape[:2])
    heading[1:] = np.cumsum(0.5 * step * (course[1:, :, 5] + course[:-1, :, 5]), axis=0)
    cos, sin = np.cos(heading), np.sin(heading)
    surge, sway = course[..., 0], course[..., 1]
    speed = np.stack([cos * surge - sin * sway, sin * surge + cos * sway], axis=-1)
    found = np.zeros_like(speed)
    found[1:] = np.cumsum(0.5 * step * (speed[1:] + speed[:-1]), axis=0)
    return found


def alone(structure: Structure, axis: str, recorded: Collection[str]) -> Structure:
    """One axis by itself, the others' velocities as measured: the same terms and inertia of that axis, and the products
    of velocities that C(ν) ν has along it, free."""
    mass = tuple(pair for pair in structure.mass if pair == (axis, axis))
    own_terms = tuple(term for term in structure.terms if term.axis == axis)
    products = (
        Term(axis, SQUARE, (one,)) if one == other else Term(axis, PRODUCT, (one, other))
        for one, other in AXES[axis].products
        if {one, other} <= set(recorded)
    )
    terms = tuple(dict.fromkeys((*own_terms, *products)))
    own = list(AXES).index(axis)
    fixed = np.eye(6)
    fixed[own, own] = structure.fixed[own, own]
    return Structure((axis,), mass, terms, tuple(name for name in structure.lags if name == axis), fixed)


def longest_course(structure: Structure, parameters: Array, motion: WholeMotion) -> Course:
    """The free run of a model with parameters (size,) over the motion's longest run."""
    run = max(motion.runs, key=lambda each: each.stop - each.start)
    cells = run.stop - run.start - 1
    course = simulate(structure, parameters[None], motion, np.array([run.start]), cells)[:, 0, 0]
    time = motion.step * np.arange(cells + 1)
    return Course(structure.axes, time, motion.velocity[run][:, structure.rows], course[:, structure.rows])


def _free_run(structure: Structure, parameters: Array, motion: WholeMotion) -> tuple[Array, Array]:
    """Errors and measured velocities of the simulated axes over whole runs, (n, axes) each."""
    found, measured = [], []
    for run in motion.runs:
        cells = run.stop - run.start - 1
        course = simulate(structure, parameters[None], motion, np.array([run.start]), cells)[:, 0, 0]
        found.append((course - motion.velocity[run])[:, structure.rows])
        measured.append(motion.velocity[run][:, structure.rows])
    return np.concatenate(found), np.concatenate(measured)


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
