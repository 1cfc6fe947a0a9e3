"""Effects that can be hidden in a trial vehicle: the physics itself, for trials of the tracer.

Nothing here is shared with what finds effects (`incsvr/effects/`): other formulations, other shapes, NumPy alone.
Every effect is a function `(Physics, Circumstances) -> (Physics, truth)`: it puts itself into the vehicle's equations
and says with which parameters. The names are those of the recording's contract; an effect on a further channel carries
the channel's name behind a colon.
"""

from __future__ import annotations

from simulator.trial_effects import channels, hull, moments, thrusters
from simulator.trial_effects.physics import Circumstances, Effect, Physics, Scale, Truth

EFFECTS: dict[str, Effect] = {
    "bias_torque": moments.bias_torque,
    "inertia": hull.inertia,
    "torque_lag": thrusters.torque_lag,
    "torque_delay": thrusters.torque_delay,
    "dead_zone": thrusters.dead_zone,
    "torque_asymmetry": thrusters.torque_asymmetry,
    "torque_saturation": thrusters.torque_saturation,
    "inflow": thrusters.inflow,
    "heading_current": moments.heading_current,
    "tether": moments.tether,
    "wave": moments.wave,
    "drag_drift": hull.drag_drift,
    "drag_step": hull.drag_step,
    "memory": hull.memory,
    "coulomb": moments.coulomb,
    "bias_drift": moments.bias_drift,
}


def named(name: str) -> Effect:
    """The effect called `name`, with `coupling:<channel>` and `modulation:<channel>` for any channel.

    Raises:
        KeyError: no effect has that name.
    """
    kind, colon, channel = name.partition(":")
    if colon and kind == "coupling":
        return channels.coupling(channel)
    if colon and kind == "modulation":
        return channels.modulation(channel)
    return EFFECTS[name]


__all__ = ["EFFECTS", "Circumstances", "Effect", "Physics", "Scale", "Truth", "named"]
