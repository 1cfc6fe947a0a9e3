"""Effects that come with a further recorded channel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simulator.trial_effects.physics import Circumstances, Effect, Physics, Truth


def coupling(channel: str) -> Effect:
    """A moment in proportion to a channel: sway past a fin, roll through a shifted centre of mass, a winch."""

    def effect(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
        values = here.channels[channel]
        strength = here.sign() * here.size * here.scale.torque * here.random.uniform(0.05, 0.07)
        coefficient = strength / float(np.std(values))
        # Speeds and rates act from zero on; what lies far from zero acts by its difference from where it began.
        origin = float(values[0]) if abs(np.mean(values)) > 3 * np.std(values) else 0.0
        table = (coefficient * (values - origin)).tolist()
        moments = (*physics.moments, lambda _rate, _heading, tick: table[tick])
        return replace(physics, moments=moments), {"coefficient": coefficient, "origin": origin}

    return effect


def modulation(channel: str) -> Effect:
    """A channel scales the thrust (a battery that sags) or the drag (cold water, depth under the surface)."""

    def effect(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
        values = here.channels[channel]
        thrust = channel == "voltage" or bool(here.random.random() < 0.5)
        # One deviation of the channel changes the thrust, or the drag, by this much.
        strength = here.sign() * here.size * here.random.uniform(0.11, 0.16)
        if channel == "voltage":
            strength = abs(strength)
        coefficient = strength / float(np.std(values))
        origin = float(np.mean(values)) if here.random.random() < 0.5 else float(values[0])
        factor = 1.0 + np.clip(coefficient * (values - origin), -0.7, 0.7)
        table = factor.tolist()
        truth: Truth = {"coefficient": coefficient, "origin": origin, "shape": "thrust" if thrust else "drag"}
        if thrust:
            scaled = (*physics.produced, lambda moment, _rate, tick: moment * table[tick])
            return replace(physics, produced=scaled), truth
        return replace(physics, drag_factors=(*physics.drag_factors, lambda tick: table[tick])), truth

    return effect
