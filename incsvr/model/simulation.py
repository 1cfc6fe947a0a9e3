"""The one integrator: Runge–Kutta of fourth order, all windows and all columns of parameters side by side.

Beside the velocities go the angles that follow from them and the memories of rows. A predictor also has a disturbance
on each axis, an acceleration that stays until a sample contradicts it: water pushes for seconds. It is corrected after
each step by its samples: a Kalman filter of fixed gain (L. Ljung, System Identification, 2nd ed., Section 4.3).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import Factors
from incsvr.model.rows import ONE, Factor, value
from incsvr.model.series import effort_of
from incsvr.model.structure import STAGES, Structure, is_logarithm
from incsvr.model.windows import ANGLES, Indices, Windows
from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES
from incsvr.plant.mass_and_coriolis import PAIRS, product_weights

RUNAWAY = 1e6
"""A speed that no vehicle reaches [m/s], at which a simulation that diverges is clipped."""


def predict(structure: Structure, columns: Array, windows: Windows, starts: Array) -> Array:
    """(samples, columns) the sensors' values at their own stamps.

    Args:
        columns: (parameters, columns) of θ, in the order of `structure.names`.
        starts: (axes, columns, windows) velocities at each window's first edge.
    """
    size = max(1, int(2e7 / ((windows.steps + 1) * starts.shape[0] * starts.shape[2])))  # some 500 MB at most
    parts = [
        _predict(structure, columns[:, k : k + size], windows, starts[:, k : k + size])
        for k in range(0, columns.shape[1], size)
    ]
    return np.concatenate(parts, axis=1)


def _predict(structure: Structure, columns: Array, windows: Windows, starts: Array) -> Array:
    course, slopes, ends = simulate(structure, columns, windows, starts)
    k, i, w, f = windows.cell, windows.axis, windows.window, windows.part[:, None]
    before, after, rise = course[k, :, i, w], ends[k, :, i, w], windows.step * slopes[k, :, i, w]
    found = np.where(f > 0.999, after, before + f * rise + f * f * (after - before - rise))
    return np.asarray(np.nan_to_num(found, nan=RUNAWAY))


def simulate(structure: Structure, columns: Array, windows: Windows, starts: Array) -> tuple[Array, Array, Array]:
    """The course of the velocities on the windows' edges, (steps + 1, columns, axes, windows); their slopes at the
    beginning of each step, (steps, …); and their values at its end before any correction, (steps, …)."""
    motion = Motion(structure, columns, windows)
    state = motion.start(starts)
    size, h = len(structure.axes), windows.step
    shape = (windows.steps, columns.shape[1], size, windows.first.size)
    course, slopes, ends = np.empty((shape[0] + 1, *shape[1:])), np.empty(shape), np.empty(shape)
    course[0] = state[:, :size]
    gains = motion.gains()
    corrections = _by_step(windows) if gains is not None else []
    with np.errstate(all="ignore"):
        for k in range(windows.steps):
            before, middle, after = motion.outside(k)
            k1 = motion.slope(state, before)
            k2 = motion.slope(state + 0.5 * h * k1, middle)
            k3 = motion.slope(state + 0.5 * h * k2, middle)
            k4 = motion.slope(state + h * k3, after)
            slopes[k] = k1[:, :size]
            k2 += k3
            k2 *= 2.0
            k2 += k1
            k2 += k4
            k2 *= h / 6.0
            state = np.clip(state + k2, -RUNAWAY, RUNAWAY)
            ends[k] = state[:, :size]
            if gains is not None:
                _correct(state, course[k], slopes[k], windows, corrections[k], gains)
            course[k + 1] = state[:, :size]
    return course, slopes, ends


class Motion:
    """The equation of motion for columns of parameters over windows: a matrix times products of factors."""

    def __init__(self, structure: Structure, columns: Array, windows: Windows) -> None:
        self._structure, self._windows, self._count = structure, windows, columns.shape[1]
        raw = dict(zip(structure.names, columns, strict=True))
        self._value = {
            name: np.exp(column) if is_logarithm(name) and not name.startswith("mass:") else column
            for name, column in raw.items()
        }
        self._angles = [
            angle for angle, rate in ANGLES.items() if angle in structure.channels and rate in structure.axes
        ]
        self._memories = [row for row in structure.rows if row.follows]
        states = [*structure.axes, *self._angles, *(f"~{row.key}" for row in self._memories)]
        if structure.predictor:
            states += [f"~disturbance@{axis}" for axis in structure.axes]
        self._outside = [effort_of(axis) for axis in structure.driven]
        self._outside += [name for name in structure.channels if name not in states]
        signals = [*states, *self._outside]
        self._place = {name: k for k, name in enumerate(signals)}
        self._states = len(states)
        self._gather(signals, structure.masses(raw or {"": np.zeros(self._count)}))
        shape = (self._count, len(signals), windows.first.size)
        self._signals = np.empty(shape)
        self._factor_values = np.ones((shape[0], self._factors.count, shape[2]))
        self._constants = [self._value[f"time:{row.key}"][:, None] for row in self._memories]
        self._edges, self._middles = self._outside_signals()

    def start(self, starts: Array) -> Array:
        """(columns, axes + angles + memories, windows) the state at the windows' first edges."""
        windows, shape = self._windows, (self._count, self._windows.first.size)
        parts = [*starts]
        parts += [windows.channel[angle][windows.first] for angle in self._angles]
        for row in self._memories:
            constants = self._value[f"time:{row.key}"]
            parts.append(np.stack([windows.memory(row, float(constant)) for constant in constants]))
        parts += [np.zeros(1)] * (self._states - len(parts))  # disturbances
        return np.stack([np.broadcast_to(part, shape) for part in parts], axis=1)

    def gains(self) -> tuple[Array, Array] | None:
        """(columns, axes) of a predictor: of the velocities, and of the disturbances [1/s]."""
        if not self._structure.predictor:
            return None
        gain, drift = (
            np.stack([self._value[f"{kind}:{axis}"] for axis in self._structure.axes], axis=1)
            for kind in ("gain", "drift")
        )
        return gain, drift

    def outside(self, k: int) -> tuple[Array, Array, Array]:
        """Efforts and channels at the beginning, middle and end of step k; efforts are means of the step."""
        efforts = len(self._structure.driven)
        before, after = self._edges[k].copy(), self._edges[k + 1].copy()
        before[:, :efforts] = after[:, :efforts] = self._middles[k][:, :efforts]
        return before, self._middles[k], after

    def slope(self, state: Array, outside: Array) -> Array:
        """The state's slope, of its own shape."""
        signals, size = self._signals, len(self._structure.axes)
        signals[:, : self._states], signals[:, self._states :] = state, outside
        factors = self._factors(signals, self._factor_values)
        force = np.matmul(self._matrix, factors[:, self._one] * factors[:, self._other])
        if self._states == size:
            return np.asarray(force)
        out = np.empty_like(state)
        out[:, :size] = force
        if self._angles:
            self._turn(out, signals)
        for j, (row, constant) in enumerate(zip(self._memories, self._constants, strict=True)):
            at = size + len(self._angles) + j
            out[:, at] = (signals[:, self._place[row.follows]] - state[:, at]) / constant
        if self._structure.predictor:  # an acceleration that lasts until a sample contradicts
            out[:, :size] += state[:, -size:]
            out[:, -size:] = 0.0
        return out

    def _gather(self, signals: list[str], masses: Array) -> None:
        """The products of factors, and the matrix (columns, axes, products) that makes accelerations of them."""
        structure, size = self._structure, len(self._structure.axes)
        at = {axis: i for i, axis in enumerate(structure.axes)}
        terms: dict[tuple[Factor, Factor], Array] = {}

        def add(one: Factor, other: Factor, axis: str, weight: Array) -> None:
            terms.setdefault((one, other), np.zeros((self._count, size)))[:, at[axis]] += weight

        for axis in structure.driven:
            add(value(effort_of(axis)), ONE, axis, np.ones(self._count))
        for row in structure.rows:
            for part in row.parts:
                add(part.one, part.other, part.axis, -part.sign * self._value[row.key])
        if structure.tied:
            whole = np.zeros((self._count, 6, 6))
            places = [VELOCITIES.index(axis) for axis in structure.axes]
            whole[:, np.array(places)[:, None], places] = masses
            weights = product_weights(whole)
            for k, (a, b) in enumerate(PAIRS):
                if a in places and b in places:
                    for axis, place in zip(structure.axes, places, strict=True):
                        if np.any(weights[:, place, k]):
                            add(value(VELOCITIES[a]), value(VELOCITIES[b]), axis, -weights[:, place, k])
        self._factors = Factors([factor for pair in terms for factor in pair], signals)
        self._one = np.array([self._factors.place[one] for one, _ in terms], dtype=np.intp)
        self._other = np.array([self._factors.place[other] for _, other in terms], dtype=np.intp)
        self._matrix = np.linalg.solve(masses, np.stack(list(terms.values()), axis=2))

    def _outside_signals(self) -> tuple[Array, Array]:
        """(steps + 1, columns, signals, windows) on the edges, and in the middles of the steps."""
        structure, windows = self._structure, self._windows
        shape = (windows.steps + 1, self._count, len(self._outside), windows.first.size)
        edges, middles = np.zeros(shape), np.zeros((shape[0] - 1, *shape[1:]))
        for j, axis in enumerate(structure.driven):
            middles[:, :, j] = self._effort(axis)
        at = windows.at
        for j, name in enumerate(self._outside[len(structure.driven) :], len(structure.driven)):
            edges[:, :, j] = windows.channel[name][at][:, None]
            middles[:, :, j] = 0.5 * (edges[:-1, :, j] + edges[1:, :, j])
        return edges, middles

    def _turn(self, out: Array, signals: Array) -> None:
        """Slopes of the angles from the velocities (Fossen 2011, Eq. 2.26); a velocity that is not recorded is zero."""

        def of(name: str) -> Array:
            return signals[:, self._place[name]] if name in self._place else np.zeros((1, 1))

        p, q, r = of("roll_rate"), of("pitch_rate"), of("yaw_rate")
        sine, cosine, pitch = np.sin(of("roll")), np.cos(of("roll")), of("pitch")
        along = q * sine + r * cosine
        upright = np.where(np.abs(np.cos(pitch)) < 0.05, 0.05, np.cos(pitch))  # beyond 87° Euler angles have no rates
        found = {
            "roll": p + along * np.sin(pitch) / upright,
            "pitch": q * cosine - r * sine,
            "heading": along / upright,
        }
        for j, angle in enumerate(self._angles):
            out[:, len(self._structure.axes) + j] = found[angle]

    def _effort(self, axis: str) -> Array:
        """(steps, columns, windows) mean efforts of an axis."""
        structure = self._structure
        own = [kind for kind in STAGES if (kind, axis) in structure.stages]
        shifts = self._value.get(f"shift:{axis}", np.zeros(self._count))
        found = []
        for p in range(self._count):
            numbers = {kind: float(self._value[f"{kind}:{axis}"][p]) for kind in own}
            stage = Stage(shift=float(shifts[p]), **numbers)
            found.append(self._windows.effort(axis, structure.ways.get(axis, "linear"), stage))
        return np.stack(found, axis=1)


def _by_step(windows: Windows) -> list[Indices]:
    """The samples in each step."""
    order = np.argsort(windows.cell, kind="stable")
    bounds = np.searchsorted(windows.cell[order], np.arange(windows.steps + 1))
    return [order[a:b] for a, b in pairwise(bounds)]


def _correct(
    state: Array, before: Array, slope: Array, windows: Windows, samples: Indices, gains: tuple[Array, Array]
) -> None:
    """Moves each velocity, and its disturbance, by its gain times the innovation of a step's sample."""
    i, w, f = windows.axis[samples], windows.window[samples], windows.part[samples][:, None]
    a, b, rise = before[:, i, w].T, state[:, i, w].T, windows.step * slope[:, i, w].T
    predicted = np.where(f > 0.999, b, a + f * rise + f * f * (b - a - rise))
    innovation = (windows.measured[samples][:, None] - predicted).T
    gain, drift = gains
    state[:, i, w] += gain[:, i] * innovation
    state[:, i - len(windows.axes), w] += drift[:, i] * innovation
