"""The effects that can be hidden, by their names in CONTRACT §5, and those that come with a further channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from simulator.second import hull_effects, thrust_path
from simulator.second.plant import Effect, Parameters, Plant, Setting

EFFECTS: Mapping[str, Effect] = {
    "bias_torque": hull_effects.bias_torque,
    "inertia": hull_effects.inertia,
    "torque_lag": thrust_path.torque_lag,
    "torque_delay": thrust_path.torque_delay,
    "dead_zone": thrust_path.dead_zone,
    "torque_asymmetry": thrust_path.torque_asymmetry,
    "torque_saturation": thrust_path.torque_saturation,
    "inflow": thrust_path.inflow,
    "heading_current": hull_effects.heading_current,
    "tether": hull_effects.tether,
    "wave": hull_effects.wave,
    "drag_drift": hull_effects.drag_drift,
    "drag_step": hull_effects.drag_step,
    "memory": hull_effects.memory,
    "coulomb": hull_effects.coulomb,
    "bias_drift": hull_effects.bias_drift,
}
COUPLED = ("sway", "surge", "roll_rate", "crane_angle", "pump_flow")
"""Channels that a moment may follow."""
MODULATING = {"voltage": "thrust", "hose_pressure": "thrust", "depth": "drag", "temperature": "drag"}
"""Channels that may scale thrust or drag, and which of the two."""
BY_CHANNEL: Mapping[str, tuple[str, ...]] = {"coupling": COUPLED, "modulation": tuple(MODULATING)}
"""The effects that come with a channel, and with which."""


def hide(plant: Plant, name: str, here: Setting) -> tuple[Plant, Parameters]:
    """The plant with an effect, and the effect's true parameters; of size zero there is none.

    Raises:
        KeyError: no effect has this name, or its channel is not among the recorded ones.
    """
    if here.size == 0.0:
        return plant, {}
    kind, colon, channel = name.partition(":")
    if colon:
        return {"coupling": coupling, "modulation": modulation}[kind](plant, here, channel)
    return EFFECTS[name](plant, here)


def coupling(plant: Plant, here: Setting, channel: str) -> tuple[Plant, Parameters]:
    """A moment that follows a channel, and a little more than in proportion where the channel is large.

    What passes through zero acts from there; what never does, from its usual value.
    """
    values = here.channels[channel]
    spread = float(np.std(values))
    origin = float(np.median(values)) if abs(np.mean(values)) > 2.0 * spread else 0.0
    coefficient = here.size * here.either_sign(here.full_torque * here.between(0.06, 0.09)) / spread
    away = values - origin
    moment = coefficient * away * (0.85 + 0.15 * np.abs(away) / spread)
    parameters: Parameters = {"coefficient": coefficient, "origin": origin}
    return replace(plant, outside=plant.outside + moment), parameters


def modulation(plant: Plant, here: Setting, channel: str) -> tuple[Plant, Parameters]:
    """A power of the channel scales thrust or drag: of the voltage the square, or whatever else its effect needs.

    The power is that by which one deviation of the channel makes about 12 to 20 %. At the channel's mean nothing is
    scaled.
    """
    values = here.channels[channel]
    mean, spread = float(np.mean(values)), float(np.std(values))
    share = here.size * here.between(0.12, 0.2)
    if MODULATING[channel] == "drag":
        share = here.either_sign(share)
    power = share * mean / spread
    factor = np.clip(values / mean, 0.05, None) ** power
    parameters: Parameters = {"coefficient": share / spread, "reference": mean, "shape": MODULATING[channel]}
    if MODULATING[channel] == "thrust":
        return replace(plant, thrust_factor=plant.thrust_factor * factor), parameters
    return replace(plant, drag_factor=plant.drag_factor * factor), parameters
