"""Effects of full size, hidden in a mission: the physics itself, with nothing of what finds them.

The eight below have one fixed size, so that tables of different seeds compare; moments are counted in the vehicle's
largest torque and times in the response of its heading control, so that an effect weighs as much on every vehicle.
On the vehicle "auv" they are 0.5 s of lag, 0.25 s of delay, 1.5 N m of dead zone and of bias and a limit of 10 N m.
The other effects are those of the trials, with the sizes that these draw.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from simulator.missions.vehicles import Vehicle
from simulator.trial_effects import Circumstances, Physics, Truth, named
from simulator.trial_effects.hull import with_growing_drag, with_other_drag
from simulator.trial_effects.moments import with_moment
from simulator.trial_effects.thrusters import with_dead_zone, with_limit, with_weak_reverse

LAG, DELAY = 0.35, 0.175
"""Time constant and delay, times the bandwidth of the heading control."""
DEAD_ZONE = BIAS = 1.5 / 18.0
"""In full torques; the dead zone's half width."""
REVERSE_LOSS = 0.18
"""What a propeller gives less astern than ahead."""
LIMIT = 10.0 / 18.0
"""In full torques."""
DRAG_GROWTH = 0.35
"""At mid-mission, or evenly until the end."""
INERTIA_LOSS = 0.20
"""Share by which the declared inertia is too large."""

Hiding = Callable[[Physics, Vehicle, Circumstances], tuple[Physics, Truth]]


def hide(name: str, physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    """The vehicle's equations with the effect in them, and the effect's parameters.

    Raises:
        KeyError: no effect has that name.
    """
    if name in FULL_SIZE:
        return FULL_SIZE[name](physics, vehicle, here)
    return named(name)(physics, here)


def _lag(physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    time = here.size * LAG / vehicle.bandwidth
    return replace(physics, rotor_time=time), {"time_constant_s": time}


def _delay(physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    delay = here.size * DELAY / vehicle.bandwidth
    return replace(physics, delay=delay), {"delay_s": delay}


def _dead_zone(physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    half = here.size * DEAD_ZONE * vehicle.scale.torque
    return with_dead_zone(physics, half), {"half_width_nm": half}


def _asymmetry(physics: Physics, _vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    efficiency = 1.0 - here.size * REVERSE_LOSS
    return with_weak_reverse(physics, efficiency), {"reverse_efficiency": efficiency}


def _saturation(physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    limit = vehicle.scale.torque * (1.0 - here.size * (1.0 - LIMIT))
    return with_limit(physics, limit), {"limit_nm": limit}


def _drag_step(physics: Physics, _vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    fraction, at = here.size * DRAG_GROWTH, 0.5 * float(here.time[-1])
    return with_other_drag(physics, here, fraction, at), {"fraction": fraction, "at_s": at}


def _drag_drift(physics: Physics, _vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    fraction = here.size * DRAG_GROWTH
    return with_growing_drag(physics, here, fraction), {"fraction": fraction}


def _bias(physics: Physics, vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    moment = here.sign() * here.size * BIAS * vehicle.scale.torque
    return with_moment(physics, lambda _rate, _heading, _tick: moment), {"moment_nm": moment}


def _inertia(physics: Physics, _vehicle: Vehicle, here: Circumstances) -> tuple[Physics, Truth]:
    true = physics.inertia * (1.0 - here.size * INERTIA_LOSS)
    return replace(physics, inertia=true), {"inertia_kg_m2": true}


FULL_SIZE: dict[str, Hiding] = {
    "torque_lag": _lag,
    "torque_delay": _delay,
    "dead_zone": _dead_zone,
    "torque_asymmetry": _asymmetry,
    "torque_saturation": _saturation,
    "drag_step": _drag_step,
    "drag_drift": _drag_drift,
    "bias_torque": _bias,
    "inertia": _inertia,
}
