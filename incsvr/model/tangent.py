"""Slopes of the predictions by all parameters and starts, along a course: the linear equation of its neighbours.

s′ = A s + G is solved step by step with the A and G of the step's middle: Φ = exp(hA), Ψ = ∫ exp(hA) to third order.
The slopes are right within some thousandths of themselves: they give directions, the simulation the errors.
"""

from __future__ import annotations

import numpy as np

from incsvr.model.factors import Factors, slopes
from incsvr.model.motion import Pair, effort, own_values, places, products
from incsvr.model.series import effort_of
from incsvr.model.simulation import Course
from incsvr.model.structure import LOGARITHMS
from incsvr.numerics import Array

NUDGE = 1e-3
"""Share of its unit by which a parameter of an effort's stage is moved for a slope."""


def tangent(course: Course, point: Array, units: Array, length: int = 32) -> Array:
    """(samples, p + axes) slopes of the predictions by units of θ, and by the starts' velocities.

    Args:
        point: (p,) θ.
        length: steps whose matrices are made at once, some megabytes.
    """
    motion, windows = course.motion, course.motion.windows
    steps = _Steps(course, point, units)
    size, wide, states, p = len(windows.axes), windows.first.size, len(motion.states), point.size
    inside = np.zeros((wide, states + steps.forced, p + size))  # s, then G
    now = inside[:, :states]
    now[:, np.arange(size), p + np.arange(size)] = 1.0
    for j, row in enumerate(motion.memories, size + len(motion.angles)):
        now[:, j, motion.structure.names.index(f"time:{row.key}")] = steps.of_first_memory[row.key]
    found, last = np.zeros((windows.measured.size, p + size)), np.empty_like(now)
    innovation = windows.measured - course.predicted
    gains = motion.gains()
    of_gain = [motion.structure.names.index(f"gain:{axis}") for axis in windows.axes] if gains else []
    of_drift = [motion.structure.names.index(f"drift:{axis}") for axis in windows.axes] if gains else []
    with np.errstate(all="ignore"):
        for first in range(0, windows.steps, length):
            whole, slope, force = steps.matrices(first, min(first + length, windows.steps))
            for k, samples in enumerate(windows.by_step[first : first + length]):
                last[:] = now
                inside[:, states:, :p] = force[k]
                now[:] = np.matmul(whole[k], inside)
                if samples is None:
                    continue
                at, w, i = samples.which, samples.window, samples.axis
                before, after, rise = samples.shares[:, :, None]
                value = before * last[w, i] + after * now[w, i]
                if np.any(rise):
                    begin = np.einsum("ms,msq->mq", slope[k][w, i], last[w])
                    begin[:, :p] += force[k][w, i]
                    value += rise * begin
                found[at] = value
                if gains is not None:
                    now[w, i] -= gains[0][0, i, None] * value
                    now[w, states - size + i] -= gains[1][0, i, None] * value
                    now[w, i, np.array(of_gain)[i]] += innovation[at] * units[np.array(of_gain)[i]]
                    now[w, states - size + i, np.array(of_drift)[i]] += innovation[at] * units[np.array(of_drift)[i]]
            np.nan_to_num(now, copy=False, posinf=0.0, neginf=0.0)  # beside what runs away
    return np.nan_to_num(found, posinf=0.0, neginf=0.0)


class _Steps:
    """A and G of the middle of each step, all windows side by side."""

    def __init__(self, course: Course, point: Array, units: Array) -> None:
        self._course, self._motion = course, course.motion
        motion, structure, windows = course.motion, course.motion.structure, course.motion.windows
        size, p = len(structure.axes), point.size
        self.forced = len(motion.states) - (size if structure.predictor else 0)
        self._units = units
        matrix = motion.matrix[0]
        by_signal: dict[Pair, Array] = {}
        count = len(motion.signals) - len(motion.channels)  # a channel is as it was measured
        for (one, other), column in zip(motion.pairs, matrix.T, strict=True):
            for factor, beside in ((one, other), (other, one)):
                for number, new, signal in slopes(factor):
                    at = motion.signals.index(signal)
                    if at < count:
                        product = by_signal.setdefault((new, beside), np.zeros((size, count)))
                        product[:, at] += number * column
        self._pairs = list(by_signal)
        self._by_signal = np.stack(list(by_signal.values())).reshape(len(by_signal), size * count)
        every = [*motion.pairs, *self._pairs]
        self._factors = Factors((factor for pair in every for factor in pair), motion.signals)
        self._one, self._other = places(self._factors, every)
        nudged = np.tile(point[:, None], (1, 2 * p)) + 1e-4 * np.hstack([np.diag(units), -np.diag(units)])
        both = products(structure, nudged)[1]
        self._by_theta = ((both[:p] - both[p:]) / 2e-4).transpose(2, 1, 0).reshape(matrix.shape[1], size * p)
        self._of_efforts = [each for axis in structure.driven for each in self._stages(axis, point)]
        self.of_first_memory = {}
        for row, constant in zip(motion.memories, (each[0, 0] for each in motion.constants), strict=True):
            unit = units[structure.names.index(f"time:{row.key}")]
            later = windows.memory(row, float(constant * np.exp(NUDGE * unit)))
            self.of_first_memory[row.key] = (later - windows.memory(row, float(constant))) / NUDGE

    def _stages(self, axis: str, point: Array) -> list[tuple[int, int, Array]]:
        """Of each parameter of an effort's stages: its place, the effort's among the signals, and (steps, windows) by
        how much its unit changes the effort."""
        motion, structure, windows = self._motion, self._motion.structure, self._motion.windows
        found = []
        for place, name in enumerate(structure.names):
            kind, _, of = name.partition(":")
            if of == axis and (kind == "shift" or (kind in LOGARITHMS and kind != "time")):
                nudged = point.copy()
                nudged[place] += NUDGE * self._units[place]
                after = effort(structure, own_values(structure, nudged[:, None]), windows, axis)
                change = (after - effort(structure, motion.value, windows, axis))[:, 0] / NUDGE
                found.append((place, motion.signals.index(effort_of(axis)), change))
        return found

    def matrices(self, first: int, last: int) -> tuple[Array, Array, Array]:
        """Of some steps: (steps, windows, states, states + forced) Φ beside Ψ, (steps, windows, states, states) A, and
        (steps, windows, forced, p) G."""
        course, motion, h = self._course, self._motion, self._motion.windows.step
        size, states, p = course.slopes.shape[1], len(motion.states), self._units.size
        steps, wide = last - first, course.slopes.shape[2]
        before, after = course.states[first:last], course.states[first + 1 : last + 1]
        middle = 0.5 * (before + after)
        middle[:, :size] = 0.75 * before[:, :size] + 0.25 * (course.ends[first:last] + h * course.slopes[first:last])
        edges = 0.5 * (motion.edges[first:last] + motion.edges[first + 1 : last + 1])
        signals = np.concatenate([middle, motion.efforts[first:last, 0], edges], axis=1)
        values = np.ones((self._factors.count, steps * wide))
        values[1 : len(motion.signals) + 1] = signals.transpose(1, 0, 2).reshape(len(motion.signals), -1)
        self._factors.fill(values)
        both = values[self._one] * values[self._other]
        count = len(motion.pairs)
        force = np.zeros((steps * wide, self.forced, p))
        force[:, :size] = (both[:count].T @ self._by_theta).reshape(-1, size, p)
        by_signal = (both[count:].T @ self._by_signal).reshape(steps * wide, size, -1)
        for place, signal, change in self._of_efforts:
            force[:, :size, place] += by_signal[:, :, signal] * change[first:last].reshape(-1, 1)
        slope = np.zeros((steps * wide, states, states))
        slope[:, :size] = by_signal[:, :, :states]
        self._besides(slope, force, values[1 : len(motion.signals) + 1])
        a = h * slope
        share = np.eye(states) + a @ (0.5 * np.eye(states) + a / 6.0)
        whole = np.concatenate([np.eye(states) + a @ share, h * share[:, :, : self.forced]], axis=2)
        shape = (steps, wide, -1)
        return (
            whole.reshape(*shape, states + self.forced),
            slope.reshape(*shape, states),
            force.reshape(*shape, p),
        )

    def _besides(self, slope: Array, force: Array, signals: Array) -> None:
        """Writes the rows of angles, memories and disturbances."""
        motion, size = self._motion, self._course.slopes.shape[1]
        if motion.angles:
            rows = slice(size, size + len(motion.angles))
            for j in range(rows.stop):
                moved = np.repeat(signals[None], 2, axis=0)
                moved[:, j] += np.array([[1e-5], [-1e-5]])
                turned = motion.turning(moved)
                slope[:, rows, j] = ((turned[0] - turned[1]) / 2e-5).T
        memories = zip(motion.memories, motion.constants, strict=True)
        for j, (row, constant) in enumerate(memories, size + len(motion.angles)):
            follows, value = motion.signals.index(row.follows), float(constant[0, 0])
            if follows < len(motion.states):
                slope[:, j, follows] += 1.0 / value
            slope[:, j, j] -= 1.0 / value
            at = motion.structure.names.index(f"time:{row.key}")
            force[:, j, at] = -(signals[follows] - signals[j]) / value * self._units[at]
        if motion.structure.predictor:
            slope[:, np.arange(size), len(motion.states) - size + np.arange(size)] = 1.0
