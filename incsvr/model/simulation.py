"""The one integrator: Runge–Kutta of fourth order, all windows and all columns of parameters side by side.

A predictor also has a disturbance on each axis, an acceleration that fades: water pushes for seconds, and not for ever.
It is corrected after each step by its samples: a Kalman filter of fixed gain (L. Ljung, System
Identification, 2nd ed., Section 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.model.motion import Motion
from incsvr.model.structure import Structure
from incsvr.model.windows import Windows
from incsvr.numerics import Array

RUNAWAY = 1e6
"""A speed that no vehicle reaches [m/s], at which a simulation that diverges is clipped."""


@dataclass(frozen=True)
class Course:
    """A simulation of one column of parameters.

    Attributes:
        motion: its equation.
        predicted: (samples,) the sensors' values at their own stamps.
        states: (steps + 1, states, windows) on the edges, the velocities first.
        slopes: (steps, axes, windows) of the velocities at the beginning of each step.
        ends: (steps, axes, windows) the velocities at its end, before any correction.
    """

    motion: Motion
    predicted: Array
    states: Array
    slopes: Array
    ends: Array


def predict(structure: Structure, columns: Array, windows: Windows, starts: Array) -> Array:
    """(samples, columns) the sensors' values at their own stamps.

    Args:
        columns: (parameters, columns) of θ, in the order of `structure.names`.
        starts: (axes, columns, windows) velocities at each window's first edge.
    """
    return _run(Motion(structure, columns, windows), starts, None)


def simulate(structure: Structure, point: Array, windows: Windows, starts: Array) -> Course:
    """The course of one column of parameters, from (axes, windows) velocities at each window's first edge."""
    motion = Motion(structure, point[:, None], windows)
    size, shape = len(structure.axes), (windows.steps, len(motion.states), windows.first.size)
    course = Course(
        motion, np.empty(windows.measured.size), np.empty((shape[0] + 1, *shape[1:])),
        np.empty((shape[0], size, shape[2])), np.empty((shape[0], size, shape[2])),
    )  # fmt: skip
    course.predicted[:] = _run(motion, starts[:, None], course)[:, 0]
    return course


def _run(motion: Motion, starts: Array, course: Course | None) -> Array:
    """(samples, columns) the sensors' values; writes what a course keeps."""
    windows, gains, h = motion.windows, motion.gains(), motion.windows.step
    weights = h / 6.0 * np.array([1.0, 2.0, 2.0, 1.0])
    size, wide = len(windows.axes), windows.first.size
    state = np.ascontiguousarray(motion.start(starts))  # its rows are written through views
    shape = state.shape
    every, before = np.zeros((4, *shape)), np.zeros(shape)
    k1, k2, k3, k4 = every
    change, part, of_stages = np.zeros(state.size), motion.state, every.reshape(4, -1)
    flatly, first, rise = (each.reshape(shape[0], -1) for each in (state, before, k1))
    found = np.zeros((windows.measured.size, shape[0]))
    with np.errstate(all="ignore"):
        for k, samples in enumerate(windows.by_step):
            before[:] = state
            part[:] = state
            motion.enter(k, 0.0)
            motion.slope(k1)
            for share, last, new in ((0.5, k1, k2), (0.5, k2, k3), (1.0, k3, k4)):
                motion.enter(k, share)
                np.multiply(last, share * h, out=part)
                np.add(part, state, out=part)
                motion.slope(new)
            np.dot(weights, of_stages, out=change)
            state += change.reshape(shape)
            np.minimum(state, RUNAWAY, out=state)
            np.maximum(state, -RUNAWAY, out=state)
            if course is not None:
                course.states[k], course.slopes[k], course.ends[k] = before[0], k1[0, :size], state[0, :size]
            if samples is not None:
                which, flat = samples.which, samples.flat
                value = flatly.take(flat, axis=1)
                if samples.inside:
                    start, end, slope = samples.shares
                    value = start * first.take(flat, axis=1) + end * value + slope * rise.take(flat, axis=1)
                found[which] = value.T
                if gains is not None:
                    innovation = windows.measured[which] - value
                    flatly[:, flat] += gains[0][:, samples.axis] * innovation
                    flatly[:, flat + (shape[1] - size) * wide] += gains[1][:, samples.axis] * innovation
        if course is not None:
            course.states[-1] = state[0]
    return np.asarray(np.nan_to_num(found, nan=RUNAWAY))
