"""The true equations of a trial vehicle, into which effects are put.

I ṙ = T(u) − D(r, t) + Σ Nᵢ: u is the commanded moment, T what the thrusters make of it, D the drag and Nᵢ the moments
that act besides (the yaw row of Fossen's manoeuvring model, SNAME signs). A moment is positive the way r is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Truth = dict[str, float | str]

ThrustMap = Callable[[float, float, int], float]
"""(moment [N m], r [rad/s], tick) -> moment [N m]."""
Moment = Callable[[float, float, int], float]
"""(r [rad/s], ψ [rad] counted on from the start, tick) -> moment [N m]."""
Factor = Callable[[int], float]
"""(tick) -> factor on the drag. A tick is half an integration step, so that RK4's stages fall on ticks."""


@dataclass(frozen=True, slots=True)
class Scale:
    """How large and how fast a vehicle is; the sizes of effects are counted in these.

    Attributes:
        inertia: I that the operator declares [kg m²].
        torque: the largest moment of the thrusters [N m].
        rate: the yaw rate at which the drag takes nine tenths of `torque` [rad/s].
    """

    inertia: float
    torque: float
    rate: float

    @property
    def time(self) -> float:
        """I r/τ: how long full torque takes to full rate [s]."""
        return self.inertia * self.rate / self.torque


@dataclass(frozen=True, slots=True)
class Physics:
    """What really moves the vehicle. Without effects: `inertia` and `drag` alone.

    Attributes:
        inertia: the true I [kg m²].
        drag: r [rad/s] -> N m, zero at zero.
        delay: what the command takes to the thrusters [s].
        commanded: maps between command and rotor, in their order.
        rotor_time: time constant of the rotors [s]; zero for none.
        rotor_speed: whether the rotor's speed n follows its set point (moment n|n|), or the moment itself does.
        produced: maps between rotor and vehicle, in their order.
        water_time: time constant with which the water around the hull takes on the hull's rate [s]; zero for none.
        water_share: share of that rate by which the hull sees the water turn.
        water_gain: moment for the water's rate [N m s/rad].
        drag_factors, moments: what scales the drag, what acts besides.
    """

    inertia: float
    drag: Callable[[float], float]
    delay: float = 0.0
    commanded: tuple[ThrustMap, ...] = ()
    rotor_time: float = 0.0
    rotor_speed: bool = False
    produced: tuple[ThrustMap, ...] = ()
    water_time: float = 0.0
    water_share: float = 0.0
    water_gain: float = 0.0
    drag_factors: tuple[Factor, ...] = ()
    moments: tuple[Moment, ...] = ()


@dataclass(frozen=True, slots=True)
class Circumstances:
    """What an effect may draw on when it is hidden.

    Attributes:
        scale: the vehicle's.
        size: 1 for a realistic effect, 0.5 for half of it, 0 for none at all.
        random: draws the parameters.
        time: (ticks,) [s].
        channels: the true further channels by name, each (ticks,).
    """

    scale: Scale
    size: float
    random: np.random.Generator
    time: Array
    channels: Mapping[str, Array] = field(default_factory=dict)

    def sign(self) -> float:
        """Either sign, equally often."""
        return 1.0 if self.random.random() < 0.5 else -1.0


Effect = Callable[[Physics, Circumstances], tuple[Physics, Truth]]
