"""The one integrator: Runge–Kutta of fourth order, all windows and all columns of parameters side by side.

A predictor also has a disturbance on each axis, an acceleration that stays until a sample contradicts it: water pushes
for seconds. It is corrected after each step by its samples: a Kalman filter of fixed gain (L. Ljung, System
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
    size, wide = len(windows.axes), windows.first.size
    state = motion.start(starts)
    shape = state.shape
    k1, k2, k3, k4, inside, before = (np.zeros(shape) for _ in range(6))
    found = np.zeros((windows.measured.size, shape[0]))
    with np.errstate(all="ignore"):
        for k, samples in enumerate(windows.by_step):
            before[:] = state
            motion.enter(k, 0.0)
            motion.slope(state, k1)
            motion.enter(k, 0.5)
            for share, last, new in ((0.5 * h, k1, k2), (0.5 * h, k2, k3), (h, k3, k4)):
                if new is k4:
                    motion.enter(k, 1.0)
                np.multiply(last, share, out=inside)
                inside += state
                motion.slope(inside, new)
            k2 += k3
            k2 *= 2.0
            k2 += k1
            k2 += k4
            k2 *= h / 6.0
            state += k2
            np.minimum(state, RUNAWAY, out=state)
            np.maximum(state, -RUNAWAY, out=state)
            if course is not None:
                course.states[k], course.slopes[k], course.ends[k] = before[0], k1[0, :size], state[0, :size]
            if samples is not None:
                at, flat = samples.which, samples.flat
                parts = (each.reshape(shape[0], -1).take(flat, axis=1) for each in (before, state, k1))
                value = sum(share * part for share, part in zip(samples.shares, parts, strict=True))
                found[at] = value.T
                if gains is not None:
                    innovation = windows.measured[at] - value
                    flatly = state.reshape(shape[0], -1)
                    flatly[:, flat] += gains[0][:, samples.axis] * innovation
                    flatly[:, flat + (shape[1] - size) * wide] += gains[1][:, samples.axis] * innovation
        if course is not None:
            course.states[-1] = state[0]
    return np.asarray(np.nan_to_num(found, nan=RUNAWAY))
