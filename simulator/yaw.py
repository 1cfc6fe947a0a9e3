"""What acts about yaw besides products of velocities, once a step in plain floats: a curve of drag, what is hidden."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from incsvr.numerics import Array
from simulator.physics import STEP, Course, Physics
from simulator.vehicles import Vehicle


class Yaw:
    """The yaw of one vehicle from the moment on at which this is hidden in it.

    Args:
        vehicle: whose drag it is.
        physics: what is hidden.
        asked: the moment that is asked of the thrusters now [N m].
        rate: the yaw rate now [rad/s].
    """

    def __init__(self, vehicle: Vehicle, physics: Physics, asked: float, rate: float) -> None:
        self._drag: Callable[[float], float] | None = None
        self._plain = vehicle.curve is None
        if vehicle.curve is not None or physics.drag or physics.wakes:
            linear, quadratic = float(vehicle.linear[5]), float(vehicle.quadratic[5])
            self._drag = vehicle.curve or (lambda r: r * (linear + quadratic * abs(r)))
        self._physics = physics
        self._stages = [make(asked) for make in physics.stages]
        self._waters = [
            [share, gain, -math.expm1(-STEP / time), rate]
            for share, gain, time in [(w, 0.0, t) for w, t in physics.wakes] + [(0.0, g, t) for g, t in physics.pulls]
        ]
        self._thrust: list[float] = []
        self._factor: list[float] = []
        self._last: float | None = None

    @staticmethod
    def needed(vehicle: Vehicle, physics: Physics) -> bool:
        """Whether anything acts besides."""
        p = physics
        acting = (p.stages, p.losses, p.thrust, p.drag, p.moments, p.wakes, p.pulls)
        return vehicle.curve is not None or any(acting)

    def block(self, time: Array) -> None:
        """The steps that come next are at these times [s]."""
        self._thrust, self._factor = _product(self._physics.thrust, time), _product(self._physics.drag, time)

    def besides(self, step: int, asked: float, r: float, heading: float) -> float:
        """The moment besides the one that is asked [N m], at a step of the block."""
        thrust = asked
        for stage in self._stages:
            thrust = stage(thrust)
        if self._thrust:
            thrust *= self._thrust[step]
        moment, carried = 0.0, 0.0
        for water in self._waters:
            share, gain, part, rate = water
            carried += share * rate
            moment += gain * rate
            water[3] = rate + part * (r - rate)
        if self._drag is not None:
            drag = self._drag(r - carried)
            if self._factor:
                drag *= self._factor[step]
            moment -= drag - self._drag(r) if self._plain else drag
        for acts in self._physics.moments:
            moment += acts(r, heading)
        for loss in self._physics.losses:
            moment -= loss(thrust, r)
        # Adams and Bashforth, as the hull; the thrust holds over a step.
        before, self._last = moment if self._last is None else self._last, moment
        return thrust - asked + 1.5 * moment - 0.5 * before


def _product(courses: Sequence[Course], time: Array) -> list[float]:
    """The product of courses; empty for none."""
    return np.prod([course(time) for course in courses], axis=0).tolist() if courses else []
