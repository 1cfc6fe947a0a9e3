"""The hulls of many vehicles side by side: Fossen's equations as products of the state, integrated at 2 ms.

M ν̇ + C(ν) ν + D(ν) ν + g(η) = τ, with ν through the water; the attitude is a quaternion q. Every term but the drag of a
curve is a product of two of ν, |ν|, q and 1, so that a step is one matrix of weights a vehicle. Adams and Bashforth's
second order; efforts hold over a step and enter as they are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.mass_and_coriolis import PAIRS, product_weights
from simulator.physics import STEP
from simulator.vehicles import NAMES, YAW, Vehicle

_Q, _ABS, _ONE, _STATES, _ALL = 6, 10, 16, 10, 17
# q̇ = ½ q ⊗ (0, ω): row of q̇, sign, row of q, axis of ω.
_TURNING = (
    (0, -1, 1, 3), (0, -1, 2, 4), (0, -1, 3, 5), (1, 1, 0, 3), (1, -1, 3, 4), (1, 1, 2, 5),
    (2, 1, 3, 3), (2, 1, 0, 4), (2, -1, 1, 5), (3, -1, 2, 3), (3, 1, 1, 4), (3, 1, 0, 5),
)  # fmt: skip


def _features(vehicle: Vehicle) -> tuple[dict[tuple[int, int], Array], Array]:
    """The weights (10,) of each product in the rates of ν and q, and M⁻¹ (6, 6) of the axes that move."""
    moving = np.array([name in vehicle.moves for name in NAMES])
    mass = np.where(np.outer(moving, moving), vehicle.mass, 0.0)
    inverse = np.linalg.inv(mass + np.diag(~moving * 1.0)) * np.outer(moving, moving)
    found: dict[tuple[int, int], Array] = {}

    def push(a: int, b: int, axis: int, value: float) -> None:
        found[a, b] = found.get((a, b), np.zeros(_STATES)) + np.append(value * inverse[:, axis], np.zeros(4))

    for (a, b), force in zip(PAIRS, product_weights(mass).T, strict=True):
        for axis in np.flatnonzero(force):
            push(a, b, int(axis), -float(force[axis]))
    for axis in np.flatnonzero(moving):
        if axis != YAW or vehicle.curve is None:
            push(int(axis), _ONE, int(axis), -float(vehicle.linear[axis]))
            push(int(axis), _ABS + int(axis), int(axis), -float(vehicle.quadratic[axis]))
    for (name, a_name, b_name), value in vehicle.crossed.items():
        push(NAMES.index(b_name), _ABS + NAMES.index(a_name), NAMES.index(name), -value)
    # Weight and buoyancy: −righting × the part of "down" along sway about roll, + × that along surge about pitch.
    for a, b, axis, sign in ((2, 3, 3, -2.0), (0, 1, 3, -2.0), (1, 3, 4, 2.0), (0, 2, 4, -2.0)):
        push(_Q + a, _Q + b, axis, sign * vehicle.righting)
    for row, sign, q, about in _TURNING:
        if moving[about]:
            weight = found.setdefault((about, _Q + q), np.zeros(_STATES))
            weight[_Q + row] += 0.5 * sign
    return found, inverse


class Hulls:
    """Vehicles side by side, at rest on an even keel at first.

    Attributes:
        inverse: (n, 6, 6) M⁻¹.
        state: (n, 10) ν through the water, and q.
    """

    def __init__(self, vehicles: Sequence[Vehicle], headings: Array) -> None:
        count = len(vehicles)
        each = [_features(vehicle) for vehicle in vehicles]
        self._pairs = sorted({pair for found, _ in each for pair, weight in found.items() if weight.any()})
        self.inverse = np.stack([inverse for _, inverse in each])
        self._weights = np.stack([self._matrix(found) for found, _ in each])
        self._both = np.array(self._pairs, dtype=np.intp).T
        self._z = np.zeros((count, _ALL))
        self._z[:, _ONE] = 1.0
        self.state = self._z[:, :_STATES]
        self.state[:, _Q], self.state[:, _Q + 3] = np.cos(0.5 * headings), np.sin(0.5 * headings)
        self._factors = np.empty((count, *self._both.shape))
        self._left, self._right = self._factors[:, 0], self._factors[:, 1]
        self._products = np.empty((count, 1, len(self._pairs)))
        self._rise = np.empty((count, 1, _STATES))
        # Parts of these arrays by names of their own: to take one anew at each step is a tenth of its time.
        self._product, self._slope = self._products[:, 0], self._rise[:, 0]
        self._speeds, self._sizes = self.state[:, :6], self._z[:, _ABS:_ONE]
        self._find_slope()
        self._behind = self.state - 0.5 * self._slope
        self._pushed = self._behind[:, :6]

    def _matrix(self, found: dict[tuple[int, int], Array]) -> Array:
        return STEP * np.stack([found.get(pair, np.zeros(_STATES)) for pair in self._pairs])

    def change(self, place: int, vehicle: Vehicle) -> None:
        """From now on a vehicle is this one, with the same damping and another mass."""
        found, self.inverse[place] = _features(vehicle)
        self._weights[place] = self._matrix(found)

    def _find_slope(self) -> None:
        """What a step adds (n, 10), without the efforts."""
        self._z.take(self._both, axis=1, out=self._factors, mode="clip")
        np.multiply(self._left, self._right, out=self._product)
        np.matmul(self._products, self._weights, out=self._rise)

    def step(self, push: Array) -> None:
        """One step on; `push` (n, 6) is M⁻¹ τ times the step."""
        self._find_slope()
        # Adams and Bashforth, x + 1.5 f − 0.5 f₋, with x − 0.5 f₋ kept.
        self._behind += self._slope
        self._pushed += push
        np.multiply(self._slope, 0.5, out=self.state)
        self.state += self._behind
        np.abs(self._speeds, out=self._sizes)

    def attitude(self) -> Array:
        """(n, 3) roll, pitch and heading [rad]; makes q a unit again."""
        size = np.sqrt(np.einsum("nk,nk->n", self.state[:, _Q:], self.state[:, _Q:]))[:, None]
        drift = self.state[:, _Q:] * (1.0 / size - 1.0)
        self.state[:, _Q:] += drift
        self._behind[:, _Q:] += drift
        w, x, y, z = self.state[:, _Q:].T
        found = np.empty((w.size, 3))
        found[:, 0] = np.arctan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
        found[:, 1] = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
        found[:, 2] = np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
        return found
