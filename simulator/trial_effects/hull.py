"""Effects of the hull and the water around it: mass, fouling, payload, water that turns with the hull."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simulator.trial_effects.physics import Array, Circumstances, Physics, Truth


def with_growing_drag(physics: Physics, here: Circumstances, fraction: float) -> Physics:
    """The drag grows evenly, by this part of itself until the end."""
    return _scaled(physics, 1.0 + fraction * here.time / here.time[-1])


def with_other_drag(physics: Physics, here: Circumstances, fraction: float, at: float) -> Physics:
    """The drag grows by this part of itself at an instant [s]."""
    return _scaled(physics, np.where(here.time >= at, 1.0 + fraction, 1.0))


def _scaled(physics: Physics, factor: Array) -> Physics:
    table = factor.tolist()
    return replace(physics, drag_factors=(*physics.drag_factors, lambda tick: table[tick]))


def inertia(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Payload, or added mass near a wall: the true I is not the declared one."""
    true = physics.inertia * (1.0 + here.sign() * here.size * here.random.uniform(0.12, 0.20))
    return replace(physics, inertia=true), {"inertia_kg_m2": true}


def drag_drift(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Weed gathers on the hull: the drag grows evenly from the first second to the last."""
    fraction = here.size * here.random.uniform(0.30, 0.45)
    return with_growing_drag(physics, here, fraction), {"fraction": fraction}


def drag_step(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """The vehicle picks something up or loses a fairing: the drag jumps."""
    fraction = here.size * here.random.uniform(0.25, 0.38)
    if here.random.random() < 0.4:
        fraction *= -0.75
    at = float(here.time[-1]) * here.random.uniform(0.3, 0.7)
    return with_other_drag(physics, here, fraction, at), {"fraction": fraction, "at_s": at}


def memory(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Water takes on the hull's rate, Tw ẇ = r − w, and the hull drags in turning water: d(r − βw), or d(r) − gw."""
    scale = here.scale
    time = scale.time * here.random.uniform(3.5, 7.0)
    share = here.size * here.random.uniform(0.22, 0.32)
    gain = share * scale.torque / scale.rate
    if here.random.random() < 0.5:
        return replace(physics, water_time=time, water_share=share), {
            "gain_nm_s": gain,
            "time_constant_s": time,
            "shape": "co-rotation",
        }
    return replace(physics, water_time=time, water_gain=gain), {
        "gain_nm_s": gain,
        "time_constant_s": time,
        "shape": "linear",
    }
