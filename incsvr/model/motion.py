"""The equation of motion: accelerations as a matrix times products of factors, for columns of parameters over windows.

Beside the velocities go the angles that follow from them, the memories of rows, and a predictor's disturbances.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import Factors, Indices
from incsvr.model.rows import ONE, Factor, Row, value
from incsvr.model.series import effort_of
from incsvr.model.structure import STAGES, Structure, is_logarithm
from incsvr.model.windows import ANGLES, Windows
from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES
from incsvr.plant.mass_and_coriolis import PAIRS, product_weights

Pair = tuple[Factor, Factor]
"""A product of two factors."""


def own_values(structure: Structure, columns: Array) -> dict[str, Array]:
    """(columns,) of each parameter by name, out of its logarithm but for the masses."""
    return {
        name: np.exp(column) if is_logarithm(name) and not name.startswith("mass:") else column
        for name, column in zip(structure.names, columns, strict=True)
    }


def products(structure: Structure, columns: Array) -> tuple[list[Pair], Array]:
    """The products of factors, and the matrix (columns, axes, products) that makes accelerations of them."""
    count, size = columns.shape[1], len(structure.axes)
    values = own_values(structure, columns)
    masses = structure.masses(values or {"": np.zeros(count)})
    at = {axis: i for i, axis in enumerate(structure.axes)}
    terms: dict[Pair, Array] = {}

    def add(one: Factor, other: Factor, axis: str, weight: Array) -> None:
        terms.setdefault((one, other), np.zeros((count, size)))[:, at[axis]] += weight

    for axis in structure.driven:
        add(value(effort_of(axis)), ONE, axis, np.ones(count))
    for row in structure.rows:
        for part in row.parts:
            add(part.one, part.other, part.axis, -part.sign * values[row.key])
    if structure.tied:
        places = [VELOCITIES.index(axis) for axis in structure.axes]
        different = {name: np.array([0.37 * (k + 1)]) for k, name in enumerate(structure.names)}
        whole = np.zeros((count + 1, 6, 6))  # the last of masses that differ, because equal ones have fewer products
        whole[:, np.array(places)[:, None], places] = np.concatenate([masses, structure.masses(different)])
        weights = product_weights(whole)
        for k, (a, b) in enumerate(PAIRS):
            if a in places and b in places:
                for axis, place in zip(structure.axes, places, strict=True):
                    if weights[-1, place, k]:
                        add(value(VELOCITIES[a]), value(VELOCITIES[b]), axis, -weights[:-1, place, k])
    return list(terms), np.asarray(np.linalg.solve(masses, np.stack(list(terms.values()), axis=2)))


def effort(structure: Structure, values: dict[str, Array], windows: Windows, axis: str) -> Array:
    """(steps, columns, windows) mean efforts of an axis, (steps, 1, windows) where all columns have the same."""
    own = {kind: values[f"{kind}:{axis}"] for kind in STAGES if (kind, axis) in structure.stages}
    if f"shift:{axis}" in values:
        own["shift"] = values[f"shift:{axis}"]
    numbers = np.array(list(own.values())) if own else np.zeros((0, 1))
    different = numbers.shape[1] if np.any(np.ptp(numbers, axis=1)) else 1
    stages = [Stage(**dict(zip(own, numbers[:, p].tolist(), strict=True))) for p in range(different)]
    return np.stack([windows.effort(axis, structure.ways.get(axis, "linear"), stage) for stage in stages], axis=1)


class Motion:
    """The equation for columns of parameters, and the signals of a step that it reads.

    Args:
        columns: (parameters, columns) of θ, in the order of `structure.names`.
    """

    def __init__(self, structure: Structure, columns: Array, windows: Windows) -> None:
        self.structure, self.windows, self.count = structure, windows, columns.shape[1]
        self.value = own_values(structure, columns)
        axes = structure.axes
        self.pairs, self.matrix = products(structure, columns)
        self.memories = [row for row in structure.rows if row.follows]
        read = _read(self.pairs, self.memories)
        self.angles = [
            angle for angle, rate in ANGLES.items() if angle in structure.channels and rate in axes and angle in read
        ]
        self.states = [*axes, *self.angles, *(f"~{row.key}" for row in self.memories)]
        if structure.predictor:
            self.states += [f"~disturbance@{axis}" for axis in axes]
        efforts = [effort_of(axis) for axis in structure.driven]
        self.channels = [name for name in structure.channels if name in read and name not in self.states]
        self.signals = [*self.states, *efforts, *self.channels]
        self.factors = Factors((factor for pair in self.pairs for factor in pair), self.signals)
        self.one, self.other = places(self.factors, self.pairs)
        several = [effort(structure, self.value, windows, axis) for axis in structure.driven]
        shape = (windows.steps, self.count if any(each.shape[1] > 1 for each in several) else 1, windows.first.size)
        self.efforts = np.zeros((shape[0], shape[1], len(efforts), shape[2]))
        for j, each in enumerate(several):
            self.efforts[:, :, j] = each
        self.edges = np.zeros((shape[0] + 1, len(self.channels), shape[2]))
        for j, name in enumerate(self.channels):
            self.edges[:, j] = windows.channel[name][windows.at]
        self.constants = [self.value[f"time:{row.key}"][:, None] for row in self.memories]
        self._at = {name: k for k, name in enumerate(self.signals)}
        if structure.predictor:
            self._fade = self.value_of("fade")[:, :, None]
        self._arrange(shape[2])

    def _arrange(self, wide: int) -> None:
        """The arrays of a step: all factors, then those products that are none of a factor and 1, beside one matrix."""
        size, states, count = len(self.structure.axes), len(self.states), self.factors.count
        true = np.flatnonzero((self.one > 0) & (self.other > 0))
        self._one, self._other = self.one[true], self.other[true]
        self._whole = np.zeros((self.count, size, count + true.size))
        for k, (a, b) in enumerate(zip(self.one, self.other, strict=True)):
            if a == 0 or b == 0:
                self._whole[:, :, a + b] += self.matrix[:, :, k]
        self._whole[:, :, count:] = self.matrix[:, :, true]
        if self.structure.predictor:  # an acceleration
            self._whole[:, :, states - size + 1 : states + 1] += np.eye(size)
        self._all = np.ones((self.count, count + true.size, wide))
        self._values, self._products = self._all[:, :count], self._all[:, count:]
        self._beside = np.empty_like(self._products)
        self.state = self._values[:, 1 : states + 1]
        self._efforts = self._values[:, states + 1 : states + 1 + self.efforts.shape[2]]
        self._channels = self._values[:, states + 1 + self.efforts.shape[2] : len(self.signals) + 1]
        self._fill = self.factors.into(self._values)

    def start(self, starts: Array) -> Array:
        """(columns, states, windows) at the windows' first edges, from (axes, columns, windows) velocities."""
        windows, shape = self.windows, (self.count, self.windows.first.size)
        parts = [*starts]
        parts += [windows.channel[angle][windows.first] for angle in self.angles]
        for row, constants in zip(self.memories, self.constants, strict=True):
            parts.append(np.stack([windows.memory(row, float(constant)) for constant in constants[:, 0]]))
        parts += [np.zeros(1)] * (len(self.states) - len(parts))  # disturbances
        return np.stack([np.broadcast_to(part, shape) for part in parts], axis=1)

    def gains(self) -> tuple[Array, Array] | None:
        """(columns, axes) of a predictor: of the velocities, and of the disturbances [1/s]."""
        if not self.structure.predictor:
            return None
        return self.value_of("gain"), self.value_of("drift")

    def value_of(self, kind: str) -> Array:
        """(columns, axes) a parameter of every axis."""
        return np.stack([self.value[f"{kind}:{axis}"] for axis in self.structure.axes], axis=1)

    def enter(self, k: int, part: float) -> None:
        """Reads efforts, which are means of step k, and channels at a part of it: 0, 0.5 or 1."""
        if part == 0.0:
            self._efforts[:] = self.efforts[k]
        if self.channels:
            before, after = self.edges[k], self.edges[k + 1]
            self._channels[:] = before if part == 0.0 else after if part == 1.0 else 0.5 * (before + after)

    def slope(self, out: Array) -> None:
        """Writes the slope of `state` (columns, states, windows), at the instant that was entered."""
        size = len(self.structure.axes)
        for function in self._fill:
            function()
        if self._one.size:
            self._values.take(self._one, 1, self._products, "clip")  # any other mode copies once more
            self._values.take(self._other, 1, self._beside, "clip")
            np.multiply(self._products, self._beside, out=self._products)
        if self.count == 1:
            np.dot(self._whole[0], self._all[0], out=out[0, :size])
        else:
            np.matmul(self._whole, self._all, out=out[:, :size])
        if self.angles:
            self.turning(self._values[:, 1:], out[:, size : size + len(self.angles)])
        if self.structure.predictor:
            np.multiply(self.state[:, -size:], -self._fade, out=out[:, -size:])
        for j, (row, constant) in enumerate(zip(self.memories, self.constants, strict=True), size + len(self.angles)):
            out[:, j] = (self._values[:, 1 + self._at[row.follows]] - self.state[:, j]) / constant

    def turning(self, signals: Array, out: Array) -> None:
        """Writes the slopes of the angles (…, angles, windows), made of (…, signals, windows) (Fossen 2011, Eq. 2.26);
        a velocity or an angle that is not recorded is zero."""
        p, q, r, roll, pitch = (
            signals[..., self._at[name], :] if name in self._at else 0.0
            for name in ("roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch")
        )
        sine, cosine, upright = np.sin(roll), np.cos(roll), np.cos(pitch)
        upright = np.where(np.abs(upright) < 0.05, 0.05, upright)  # beyond 87° Euler angles have no rates
        turning = (q * sine + r * cosine) / upright
        for j, angle in enumerate(self.angles):
            if angle == "roll":
                out[..., j, :] = p + turning * np.sin(pitch)
            else:
                out[..., j, :] = q * cosine - r * sine if angle == "pitch" else turning


def _read(pairs: Sequence[Pair], memories: Sequence[Row]) -> set[str]:
    """Signals that the equation reads; each angle turns with the other velocities and angles."""
    kinds = {factor.kind for pair in pairs for factor in pair}
    found = {factor.of for pair in pairs for factor in pair} | {row.follows for row in memories}
    if any(kind.startswith("down") for kind in kinds):
        found |= {"roll", "pitch"}
    if found & ANGLES.keys():
        found |= {"roll", "pitch", *ANGLES.values()}
    return found


def places(factors: Factors, pairs: list[Pair]) -> tuple[Indices, Indices]:
    """(products,) each: where both factors of each product are."""
    one = np.array([factors.place[each] for each, _ in pairs], dtype=np.intp)
    other = np.array([factors.place[each] for _, each in pairs], dtype=np.intp)
    return one, other
