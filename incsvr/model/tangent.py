"""Slopes of the predictions by all parameters and starts, along a course: the linear equation of its neighbours.

s′ = A s + G, in which a disturbance is a part of G, is solved step by step with the A and G of the step's middle:
Φ = exp(hA) and Ψ = ∫ exp(hA) to third order. The slopes are right within some thousandths of themselves: they give
directions, and the simulation gives the errors.
"""

from __future__ import annotations

import numpy as np

from incsvr.model.factors import Factors, Indices, slopes
from incsvr.model.motion import Pair, effort, own_values, places, products
from incsvr.model.series import effort_of
from incsvr.model.simulation import Course
from incsvr.model.structure import OF_PREDICTOR, STAGES
from incsvr.numerics import Array

NUDGE = 1e-3
"""Share of its unit by which a parameter of an effort's stage is moved for a slope."""

MAX_SLOPE = 1e3
"""Largest slope of a prediction by a parameter's unit [m/s], [rad/s]: those of models that do not run away reach 10."""


def tangent(course: Course, point: Array, units: Array, length: int = 32) -> Array:
    """(samples, p + axes) slopes of the predictions by units of θ, and by the starts' velocities.

    Args:
        point: (p,) θ.
        length: steps whose matrices are made at once, some megabytes.
    """
    motion, windows = course.motion, course.motion.windows
    steps = _Steps(course, point, units)
    size, wide, forced, p = len(windows.axes), windows.first.size, steps.forced, point.size
    inside = np.zeros((wide, 2 * forced, p + size))  # s without the disturbances', then G with theirs
    now, pushes = inside[:, :forced], np.zeros((wide, size, p + size))
    axis, names = np.arange(size), motion.structure.names
    now[:, axis, p + axis] = 1.0
    for j, row in enumerate(motion.memories, size + len(motion.angles)):
        now[:, j, names.index(f"time:{row.key}")] = steps.of_first_memory[row.key]
    found = np.zeros((windows.measured.size, p + size))
    innovation, gains = windows.measured - course.predicted, motion.gains()
    if gains is not None:
        drift, fade = gains[1][0], motion.value_of("fade")[0]
        of_gain, of_drift, of_fade = ([names.index(f"{kind}:{each}") for each in windows.axes] for kind in OF_PREDICTOR)
        of_own = units[of_drift] * drift  # a drift is in θ as its logarithm
        away = windows.step * fade
        kept, usual = np.exp(-away), -np.expm1(-away) / away  # of a disturbance after a step, and its mean over it
        less, lower = -units[of_fade] * away * kept, units[of_fade] * (kept - usual)
    with np.errstate(all="ignore"):
        for first in range(0, windows.steps, length):
            at = np.flatnonzero((windows.cell >= first) & (windows.cell < first + length))
            whole, force = steps.matrices(first, min(first + length, windows.steps), at)
            place = (windows.cell[at] - first, windows.window[at], windows.axis[at])
            values, kicks = np.zeros((len(force), wide, size, p + size)), np.zeros((len(force), wide, size))
            kicks[place] = innovation[at]
            for k, samples in enumerate(windows.by_step[first : first + length]):
                acting = inside[:, forced:]
                acting[..., :p] = force[k]
                if gains is not None:
                    disturbance = course.states[first + k, -size:].T
                    acting[:, :size, p:] = 0.0
                    acting[:, :size] += usual[:, None] * pushes
                    acting[:, axis, of_fade] += lower * disturbance
                    pushes *= kept[:, None]
                    pushes[:, axis, of_fade] += less * disturbance
                if samples is None:
                    now[:] = np.matmul(whole[k, :, :forced], inside)
                    continue
                after = np.matmul(whole[k], inside)
                now[:], values[k] = after[:, :forced], after[:, forced:]
                if gains is not None:
                    now[:, axis, of_gain] += kicks[k] * units[of_gain]
                    pushes -= drift[:, None] * values[k]
                    pushes[:, axis, of_drift] += kicks[k] * of_own
            found[at] = values[place]
            if not np.isfinite(inside.sum()):  # beside what runs away
                np.nan_to_num(now, copy=False, posinf=0.0, neginf=0.0)
                np.nan_to_num(pushes, copy=False, posinf=0.0, neginf=0.0)
    return np.where(np.abs(found) < MAX_SLOPE, found, 0.0)  # what runs away gives no direction


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
        """The parameters of an effort's stages: the place of each, that of the effort among the signals, and (steps,
        windows) by how much a unit of the parameter changes the effort."""
        motion, structure, windows = self._motion, self._motion.structure, self._motion.windows
        found = []
        for place, name in enumerate(structure.names):
            kind, _, of = name.partition(":")
            if of == axis and kind in ("shift", *STAGES):
                nudged = point.copy()
                nudged[place] += NUDGE * self._units[place]
                after = effort(structure, own_values(structure, nudged[:, None]), windows, axis)
                change = (after - effort(structure, motion.value, windows, axis))[:, 0] / NUDGE
                found.append((place, motion.signals.index(effort_of(axis)), change))
        return found

    def matrices(self, first: int, last: int, at: Indices) -> tuple[Array, Array]:
        """The matrices of some steps, in which the samples `at` lie.

        Returns:
            (steps, windows, forced + axes, 2 forced), which makes of s and G the s after a step and its corrections,
            and the slopes of the samples; and G, (steps, windows, forced, p).
        """
        course, motion, h = self._course, self._motion, self._motion.windows.step
        size, forced, p = course.slopes.shape[1], self.forced, self._units.size
        steps, wide = last - first, course.slopes.shape[2]
        before, after = course.states[first:last], course.states[first + 1 : last + 1]
        middle = 0.5 * (before + after)
        middle[:, :size] = 0.75 * before[:, :size] + 0.25 * (course.ends[first:last] + h * course.slopes[first:last])
        edges = 0.5 * (motion.edges[first:last] + motion.edges[first + 1 : last + 1])
        signals = np.concatenate([middle, motion.efforts[first:last, 0], edges], axis=1)
        values = np.ones((self._factors.count, steps * wide))
        values[1 : len(motion.signals) + 1] = signals.transpose(1, 0, 2).reshape(len(motion.signals), -1)
        for function in self._factors.into(values):
            function()
        both = values[self._one] * values[self._other]
        count = len(motion.pairs)
        force = (both[:count].T @ self._by_theta).reshape(-1, size, p)
        by_signal = (both[count:].T @ self._by_signal).reshape(steps * wide, size, -1)
        for place, signal, change in self._of_efforts:
            force[:, :, place] += by_signal[:, :, signal] * change[first:last].reshape(-1, 1)
        slope = by_signal[:, :, :forced]
        if forced > size:
            more = ((0, 0), (0, forced - size), (0, 0))
            slope, force = np.pad(slope, more), np.pad(force, more)
            self._besides(slope, force, values[1 : len(motion.signals) + 1])
        a, one = h * slope, np.eye(forced)
        share = one + a @ (0.5 * one + a / 6.0)
        whole = np.zeros((steps, wide, forced + size, 2 * forced))
        whole[:, :, :forced, :forced] = (one + a @ share).reshape(steps, wide, forced, forced)
        whole[:, :, :forced, forced:] = h * share.reshape(steps, wide, forced, forced)
        self._sample(whole, slope.reshape(steps, wide, forced, forced), first, at)
        return whole, force.reshape(steps, wide, forced, p)

    def _sample(self, whole: Array, slope: Array, first: int, at: Indices) -> None:
        """Writes the rows of samples, which are parabolas in their steps, and corrects the velocities by them."""
        windows, forced = self._motion.windows, self.forced
        k, w, i, f = windows.cell[at] - first, windows.window[at], windows.axis[at], windows.part[at][:, None]
        f = np.where(f > 0.999, 1.0, f)
        rise = windows.step * (f - f * f)
        row = f * f * whole[k, w, i]
        row[:, :forced] += rise * slope[k, w, i]
        row[np.arange(i.size), i] += 1.0 - f[:, 0] ** 2
        row[np.arange(i.size), forced + i] += rise[:, 0]
        whole[k, w, forced + i] = row
        gains = self._motion.gains()
        if gains is not None:
            whole[k, w, i] -= gains[0][0, i, None] * row

    def _besides(self, slope: Array, force: Array, signals: Array) -> None:
        """Writes the rows of angles and memories."""
        motion, size = self._motion, self._course.slopes.shape[1]
        if motion.angles:
            rows = slice(size, size + len(motion.angles))
            for j in range(rows.stop):
                moved = np.repeat(signals[None], 2, axis=0)
                moved[:, j] += np.array([[1e-5], [-1e-5]])
                turned = np.empty((2, len(motion.angles), moved.shape[-1]))
                motion.turning(moved, turned)
                slope[:, rows, j] = ((turned[0] - turned[1]) / 2e-5).T
        memories = zip(motion.memories, motion.constants, strict=True)
        for j, (row, constant) in enumerate(memories, size + len(motion.angles)):
            follows, value = motion.signals.index(row.follows), float(constant[0, 0])
            if follows < self.forced:
                slope[:, j, follows] += 1.0 / value
            slope[:, j, j] -= 1.0 / value
            at = motion.structure.names.index(f"time:{row.key}")
            force[:, j, at] = -(signals[follows] - signals[j]) / value * self._units[at]
