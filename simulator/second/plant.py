"""What truly moves a vehicle, and what an effect may draw on when it is hidden in it.

I ṙ = a − f d(r − c) + Σ N: a is what the thrusters make of the command, f scales the drag, c is the rate of the water
that turns along, N are all other moments [N m], positive the way r is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Curve = Callable[[float], float]
Parameters = dict[str, float | str]

STEP = 0.01
"""Step of the integration [s]: a fortieth of the fastest vehicle's time scale; controllers' periods are multiples."""

Stage = Callable[[float], float]
"""One piece of the way from command to thrust. Called once a step, in order, it may remember: moment -> moment."""


@dataclass(frozen=True, slots=True)
class Plant:
    """A vehicle as it truly is. Without effects: inertia and drag alone.

    Attributes:
        inertia: true I [kg m²].
        drag: d(r) [N m].
        drag_factor: (n,) f at each step.
        thrust_factor: (n,) by which the thrust is scaled at each step.
        outside: (n,) moments that follow from nothing in the vehicle's own motion [N m].
        stages: makers of the pieces between command and thrust; each run makes its own, since they remember.
        losses: (thrust [N m], r [rad/s]) -> what is lost of the thrust [N m].
        moments: (r [rad/s], ψ [rad]) -> further moments [N m].
        wakes: (share of the hull's rate, time constant [s]) of each body of water that turns along.
    """

    inertia: float
    drag: Curve
    drag_factor: Array
    thrust_factor: Array
    outside: Array
    stages: tuple[Callable[[], Stage], ...] = ()
    losses: tuple[Callable[[float, float], float], ...] = ()
    moments: tuple[Callable[[float, float], float], ...] = ()
    wakes: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Setting:
    """What an effect may draw on.

    Attributes:
        full_torque, full_rate, time_scale: the vehicle's [N m], [rad/s], [s].
        start: heading at the beginning [rad].
        swing: how far the heading usually is from where it began [rad].
        size: 1 for a realistic effect, 0.5 for about half of its moment.
        random: the effect's own chance.
        time: (n,) of the steps [s].
        channels: the true further channels by name, each (n,).
    """

    full_torque: float
    full_rate: float
    time_scale: float
    start: float
    swing: float
    size: float
    random: np.random.Generator
    time: Array
    channels: Mapping[str, Array]

    def between(self, low: float, high: float) -> float:
        """A number of this range."""
        return float(self.random.uniform(low, high))

    def heads(self) -> bool:
        """One of two, equally often."""
        return bool(self.random.random() < 0.5)

    def either_sign(self, value: float) -> float:
        """The value, or its negative."""
        return value if self.heads() else -value


Effect = Callable[[Plant, Setting], tuple[Plant, Parameters]]
"""Hides itself in a plant, and says with which parameters (CONTRACT §5), and of which shape where it has several."""
