"""What may be hidden in a vehicle, what it may draw on, and how it acts: the form that both lists of effects share.

The yaw row of Fossen's equations (SNAME signs): I ṙ = thrust(τ) − f d(r − w) + N. An effect changes the thrust, the
factor f, the water's rate w, the moments N or I.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from simulator.vehicles import Vehicle

Array = NDArray[np.float64]
Truth = dict[str, float | str]
Course = Callable[[Array], Array]
"""t (n,) [s] → (n,)."""
Stage = Callable[[float], float]
"""A piece of the way from command to thrust, called once a step; it may remember: moment → moment [N m]."""
MakeStage = Callable[[float], Stage]
"""The moment at which a stage stands when it comes on [N m] → the stage."""

STEP = 0.002
"""Step of every integration [s]: a two-hundredth of the quickest vehicle's time scale."""


@dataclass(frozen=True, slots=True)
class Physics:
    """What a vehicle hides; nothing by default.

    Attributes:
        stages: between command and thrust, in their order.
        losses: (thrust [N m], r [rad/s]) → what is lost of the thrust [N m].
        thrust: factors on the thrust.
        drag: factors on the drag.
        moments: (r [rad/s], ψ [rad], counted on) → a moment besides [N m].
        outside: moments besides that follow from time alone [N m].
        wakes: (w, T) of bodies of water that take on the hull's rate with time constant T [s]: the hull drags in water
            that turns at w times their rate.
        pulls: (g, T) of such bodies that pull the hull along with g times their rate [N m s/rad].
        inertia: factors on I.
    """

    stages: tuple[MakeStage, ...] = ()
    losses: tuple[Callable[[float, float], float], ...] = ()
    thrust: tuple[Course, ...] = ()
    drag: tuple[Course, ...] = ()
    moments: tuple[Callable[[float, float], float], ...] = ()
    outside: tuple[Course, ...] = ()
    wakes: tuple[tuple[float, float], ...] = ()
    pulls: tuple[tuple[float, float], ...] = ()
    inertia: tuple[float, ...] = ()

    def __add__(self, other: Physics) -> Physics:
        return Physics(*(getattr(self, each.name) + getattr(other, each.name) for each in fields(self)))


@dataclass(frozen=True, slots=True)
class Setting:
    """What an effect may draw on when it is hidden.

    Attributes:
        inertia: I that the operator declares [kg m²].
        torque: the largest moment of the thrusters [N m].
        rate: the yaw rate at which the drag takes nine tenths of `torque` [rad/s].
        size: 1 for a realistic effect, 0.5 for half of it.
        random: draws the parameters.
        duration: of the mission [s].
        start: the heading at its start [rad].
        swing: how far the heading usually goes from there [rad].
        channel: the further channel that the effect follows, and its true course: times [s] and values.
    """

    inertia: float
    torque: float
    rate: float
    size: float
    random: np.random.Generator
    duration: float
    start: float = 0.0
    swing: float = 1.0
    channel: str = ""
    course: tuple[Array, Array] = (np.empty(0), np.empty(0))

    @property
    def time(self) -> float:
        """I r/τ: how long full torque takes to the full rate without drag [s]."""
        return self.inertia * self.rate / self.torque

    def between(self, low: float, high: float) -> float:
        """A number of this range."""
        return float(self.random.uniform(low, high))

    def heads(self, part: float = 0.5) -> bool:
        """Whether something happens that happens so often."""
        return bool(self.random.random() < part)

    def sign(self) -> float:
        """Either sign, equally often."""
        return 1.0 if self.heads() else -1.0


def static(change: Stage) -> MakeStage:
    """A stage that remembers nothing."""
    return lambda _moment: change


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
