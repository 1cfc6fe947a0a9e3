"""What the recordings say about the declaration itself, told as notes: an inertia far off, a torque that is missing."""

from __future__ import annotations

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.weak.problem import Problem

FAR = 3.0
"""Factor between the declared inertia and the one that torque and acceleration show beyond which it is said.

Hidden effects and a closed loop bring forth 2: that is what the tracer is for.
"""

LEAST_EXPLAINED = 0.5
"""Part of the torque that acceleration and drag must explain before it says anything about the inertia."""

OWN = 0.3
"""Part of what drag leaves that the acceleration must explain: a vehicle that turns steadily does not show its own."""


def remarks(problem: Problem) -> tuple[str, ...]:
    """Notes on what was declared or recorded, one sentence each with its cure; empty where nothing is odd."""
    torque = problem.signals.torque
    if not np.any(torque):
        return ("the torque is zero throughout: if the thrusters were used, its stream is missing",)
    ends = apparent_inertia(problem)
    declared = problem.signals.inertia
    if ends is None or ends[0] / FAR <= declared <= FAR * ends[1]:
        return ()
    about = float(np.sqrt(ends[0] * ends[1]))
    return (
        f"torque and acceleration go together as with an inertia of about {about:.3g} kg m²; check the declared "
        f"{declared:.4g} kg m² and whether the torque is in N m",
    )


def apparent_inertia(problem: Problem) -> tuple[float, float] | None:
    """Between which inertias [kg m²] plain least squares puts the vehicle; None where they cannot say.

    τ = I ṙ + b r + c r|r| + d over block means. Noise in ṙ lowers the I of τ on ṙ, noise in τ raises that of ṙ on τ:
    the truth lies between them (Frisch).
    """
    blocks, s = problem.blocks, problem.signals
    torque = blocks.mean(s.torque)
    drag = np.column_stack([np.ones(torque.size), blocks.mean(s.rate), blocks.mean(s.rate * np.abs(s.rate))])
    slope = _beside(drag, blocks.slope(s.ends))
    left = _beside(drag, torque)
    together, square = float(slope @ left), float(slope @ slope)
    spread, beside_drag = float(np.sum((torque - np.mean(torque)) ** 2)), float(left @ left)
    if together <= 0.0 or beside_drag <= 0.0:
        return None
    own = together**2 / (square * beside_drag)
    explained = 1.0 - (1.0 - own) * beside_drag / spread
    if own < OWN or explained < LEAST_EXPLAINED:
        return None
    low = together / square
    return low, low / own


def _beside(drag: Array, values: Array) -> Array:
    """What drag does not explain of them."""
    left: Array = values - drag @ np.linalg.lstsq(drag, values, rcond=None)[0]
    return left
