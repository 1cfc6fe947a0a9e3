"""A trial vehicle in motion: its true equations, integrated.

Two vehicles, one of the paper's scale and a small one, whose drag is no polynomial. Runge and Kutta's fourth order at
a fine fixed step in plain floats: one run has so few states that arrays would only cost calls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simulator.trial_command import Command
from simulator.trial_effects import Physics, Scale
from simulator.trial_effects.physics import Array

STEP = 0.025
"""[s] of integration; a tick is half of it. The fastest vehicle's eigenvalue times this is below 0.4."""

SCALES = {
    "leng": Scale(inertia=350.0, torque=100.0, rate=0.25),
    "small": Scale(inertia=1.0, torque=6.0, rate=1.8),
}


def _crisis(x: float) -> float:
    """Linear and quadratic, until the boundary layer turns turbulent and a third of the quadratic part is lost."""
    lost = 0.35 / (1.0 + math.exp(-(abs(x) - 0.6) / 0.12))
    return 0.35 * x + 0.8 * x * abs(x) * (1.0 - lost)


def _power(x: float) -> float:
    """A blunt body between Stokes' law and the quadratic one."""
    return 0.15 * x + 0.85 * math.copysign(abs(x) ** 1.65, x)


def _plates(x: float) -> float:
    """Plates from which the flow separates early."""
    return 0.3 * math.tanh(2.0 * x) + 0.7 * x * abs(x)


def _rising(x: float) -> float:
    """Drag that rises ever faster: waves made near the surface."""
    return math.sinh(1.8 * x) / math.sinh(1.8)


def _lopsided(x: float) -> float:
    """Another drag to either side, smooth through zero: a hull with a sensor head."""
    return _power(x) * (1.0 + 0.10 * math.tanh(4.0 * x))


DRAGS: dict[str, Callable[[float], float]] = {
    "crisis": _crisis,
    "power": _power,
    "plates": _plates,
    "rising": _rising,
    "lopsided": _lopsided,
}


def drag(shape: str, scale: Scale) -> Callable[[float], float]:
    """d(r): r [rad/s] -> N m, zero at zero, nine tenths of the full torque or so at the full rate."""
    curve, rate, moment = DRAGS[shape], scale.rate, 0.9 * scale.torque
    return lambda r: moment * curve(r / rate)


@dataclass(frozen=True, slots=True)
class Motion:
    """What truly happened, at every integration step.

    Attributes:
        time: (n,) [s].
        yaw_rate: (n,) r [rad/s].
        heading: (n,) ψ [rad], counted on.
        command: (n,) the moment that was asked of the thrusters [N m].
        acceleration: (n,) ṙ [rad/s²].
    """

    time: Array
    yaw_rate: Array
    heading: Array
    command: Array
    acceleration: Array


Response = Callable[[float, int, float, float, float, float, float], tuple[float, float, float]]
"""(commanded moment [N m], tick, other moment [N m], r, ψ, rotor's state, water's rate) -> the slopes of r, of the
rotor's state and of the water's rate."""


def response(physics: Physics) -> Response:
    """How the vehicle answers to a command that has reached its thrusters, and to the water's moment."""
    inertia, curve = physics.inertia, physics.drag
    commanded, produced, moments, factors = (
        physics.commanded,
        physics.produced,
        physics.moments,
        physics.drag_factors,
    )
    rotor_time, rotor_speed = physics.rotor_time, physics.rotor_speed
    water_time, share, gain = physics.water_time, physics.water_share, physics.water_gain

    def slopes(
        moment: float, tick: int, noise: float, r: float, psi: float, rotor: float, w: float
    ) -> tuple[float, float, float]:
        for change in commanded:
            moment = change(moment, r, tick)
        rotor_slope = 0.0
        if rotor_time:
            if rotor_speed:
                rotor_slope = (math.copysign(math.sqrt(abs(moment)), moment) - rotor) / rotor_time
                moment = rotor * abs(rotor)
            else:
                rotor_slope = (moment - rotor) / rotor_time
                moment = rotor
        for change in produced:
            moment = change(moment, r, tick)
        water_slope = 0.0
        if water_time:
            water_slope = (r - w) / water_time
            damping = curve(r - share * w) - gain * w
        else:
            damping = curve(r)
        for factor in factors:
            damping *= factor(tick)
        moment += noise - damping
        for other in moments:
            moment += other(r, psi, tick)
        return moment / inertia, rotor_slope, water_slope

    return slopes


@dataclass(frozen=True, slots=True)
class Onset:
    """What comes on while the vehicle moves: from this step on its true equations are these."""

    step: int
    physics: Physics

    def rotor(self, moment: float) -> float:
        """The state of rotors that turn as this moment [N m] asks, when they begin to lag."""
        return math.copysign(math.sqrt(abs(moment)), moment) if self.physics.rotor_speed else moment


@dataclass(frozen=True, slots=True)
class Gyro:
    """When the gyro samples, and by how much each sample is off: what the log keeps is what a controller sees.

    Attributes:
        time: (m,) [s], increasing.
        error: (m,) [rad/s].
        step: its resolution [rad/s], 0 for none.
    """

    time: Array
    error: Array
    step: float = 0.0

    def seen(self, motion: Motion) -> Array:
        """(m,) the samples [rad/s]."""
        values = np.interp(self.time, motion.time, motion.yaw_rate) + self.error
        return np.asarray(np.round(values / self.step) * self.step if self.step else values)


Slopes = Callable[[int, float, float, float, float, float], tuple[float, float, float]]
"""(tick, other moment [N m], r, ψ, rotor's state, water's rate) -> the slopes of r, of the rotor's state and of the
water's rate."""


def step_on(
    slopes: Slopes, tick: int, noise: float, r: float, psi: float, rotor: float, w: float
) -> tuple[float, float, float, float, float]:
    """r, ψ, the rotor's state and the water's rate a step after a tick by Runge and Kutta's fourth order, and ṙ at the
    tick. The slope of ψ is r."""
    h, half = STEP, STEP / 2
    a1, c1, d1 = slopes(tick, noise, r, psi, rotor, w)
    b2 = r + half * a1
    a2, c2, d2 = slopes(tick + 1, noise, b2, psi + half * r, rotor + half * c1, w + half * d1)
    b3 = r + half * a2
    a3, c3, d3 = slopes(tick + 1, noise, b3, psi + half * b2, rotor + half * c2, w + half * d2)
    b4 = r + h * a3
    a4, c4, d4 = slopes(tick + 2, noise, b4, psi + h * b3, rotor + h * c3, w + h * d3)
    sixth = h / 6
    return (
        r + sixth * (a1 + 2 * (a2 + a3) + a4),
        psi + sixth * (r + 2 * (b2 + b3) + b4),
        rotor + sixth * (c1 + 2 * (c2 + c3) + c4),
        w + sixth * (d1 + 2 * (d2 + d3) + d4),
        a1,
    )


class _GyroInLoop:
    """What a controller sees: the newest sample at each step."""

    def __init__(self, gyro: Gyro | None) -> None:
        self._samples = [] if gyro is None else list(zip(gyro.time.tolist(), gyro.error.tolist(), strict=True))
        self._resolution = 0.0 if gyro is None else gyro.step
        self._newest, self._rate = 0, 0.0

    def at(self, step: int, r: float, before: float) -> float:
        """The rate that is seen at a step, with the true rates at it and at the step before [rad/s]."""
        while self._newest < len(self._samples) and self._samples[self._newest][0] <= step * STEP:
            time, error = self._samples[self._newest]
            rate = r - (step - time / STEP) * (r - before) + error
            self._rate = round(rate / self._resolution) * self._resolution if self._resolution else rate
            self._newest += 1
        return self._rate


def move(
    physics: Physics,
    command: Command,
    water: Array,
    heading: float,
    onset: Onset | None = None,
    gyro: Gyro | None = None,
) -> Motion:
    """Integrates the vehicle from rest.

    Args:
        physics: its true equations.
        command: what is asked of the thrusters.
        water: (n,) the moment of the water's noise in each step [N m].
        heading: ψ at the start [rad].
        onset: what comes on under way; None for nothing.
        gyro: what a controller sees.

    Returns:
        the motion at the n steps.
    """
    respond = response(physics)
    late = physics.delay / STEP
    asked: list[float] = []
    held = command.hold > 0

    def delayed(tick: int) -> float:
        """The command of `delay` ago, linear between steps where it runs on; before the start it is the first."""
        position = tick / 2 - late
        if position <= 0:
            return asked[0]
        step = min(int(position), len(asked) - 1)
        after = asked[min(step + 1, len(asked) - 1)]
        return asked[step] if held else asked[step] + (position - step) * (after - asked[step])

    def slopes(tick: int, noise: float, r: float, psi: float, rotor: float, w: float) -> tuple[float, float, float]:
        moment = delayed(tick) if late else asked[-1] if held else command.at(tick, r, 0.0)[0]
        return respond(moment, tick, noise, r, psi, rotor, w)

    r, psi, integrated, rotor, w = 0.0, heading, 0.0, 0.0, 0.0
    rates, headings, accelerations = list[float](), list[float](), list[float]()
    in_loop = _GyroInLoop(gyro)
    for step, noise in enumerate(water.tolist()):
        rate = in_loop.at(step, r, rates[-1] if rates else r)
        if not held or step % command.hold == 0:
            moment, error = command.at(2 * step, rate, integrated)
            integrated += error * command.hold * STEP
        asked.append(moment)
        if onset is not None and step == onset.step:
            respond, late = response(onset.physics), onset.physics.delay / STEP
            rotor, w = onset.rotor(asked[-1]), r
        rates.append(r)
        headings.append(psi)
        r, psi, rotor, w, acceleration = step_on(slopes, 2 * step, noise, r, psi, rotor, w)
        accelerations.append(acceleration)
    time = STEP * np.arange(water.size, dtype=np.float64)
    return Motion(time, np.array(rates), np.array(headings), np.array(asked), np.array(accelerations))
