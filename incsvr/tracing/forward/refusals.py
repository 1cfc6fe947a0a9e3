"""What recordings cannot answer, each refused in one sentence with its cure, and what looks odd in the declaration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.signals.scales import white_noise
from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.projection import Projection
from incsvr.tracing.forward.thresholds import IDLE, IDLE_RATE, LEAST_KNOWN, LEAST_RATE

Array = NDArray[np.float64]

FEWEST_SCALES = 20.0
"""Time scales of the motion that the recordings must last: fewer hold too few independent moments."""

EXPLAINED = 0.3
"""Of the torque that acceleration and rate must explain before their signs say anything."""

FAR = 3.0
"""Factor between the declared inertia and the one that torque and acceleration show beyond which it is said: hidden
effects and a closed loop bring forth two."""

OWN = 0.3
"""Part of what drag leaves that the acceleration must explain: a vehicle that turns steadily does not show its own."""


def refuse_opposite_signs(grid: Grid) -> None:
    """Raises BadInput where τ = a ṙ + b r fits with both a and b negative: the vehicle turns against its thrust."""
    torque, rate = grid.signals.torque, grid.signals.rate + 0.5 * grid.rise
    design = np.stack([grid.rise / grid.cell, rate], axis=1)
    theta = np.linalg.lstsq(design, torque)[0]
    explained = 1.0 - float(np.sum((torque - design @ theta) ** 2)) / max(float(torque @ torque), 1e-300)
    if explained > EXPLAINED and theta[0] < 0.0 and theta[1] < 0.0:
        raise BadInput(
            "torque and yaw rate count in opposite directions (the vehicle turns against its thrust): multiply torque "
            "by −1, it must be positive the way yaw_rate is"
        )


def refuse_too_little_motion(grid: Grid, base: Fit) -> None:
    """Raises BadInput where the vehicle hardly moves, or its torque hardly moves it: there anything explains
    everything."""
    s = grid.signals
    if float(np.ptp(s.torque)) == 0.0:
        return  # what turns a vehicle whose thrusters stand still is another question
    fastest = float(np.quantile(np.abs(s.rate), 0.99))
    scatter = white_noise(np.diff(s.rate, 3))
    unsure = _gain_error(grid, base)
    idle = float(np.mean(np.abs(s.torque) < 0.02 * max(float(np.max(np.abs(s.torque))), 1e-300)))
    least = IDLE_RATE if idle > IDLE else LEAST_RATE
    if unsure > LEAST_KNOWN or fastest < least * scatter:
        raise BadInput(
            f"too little motion: 99 % of the yaw rates are below {fastest:.2g} rad/s where the gyro scatters by "
            f"{scatter:.1g}, the torque is next to zero for {idle:.0%} of the time, and what it does would leave the "
            f"inertia uncertain by {min(unsure, 9.99):.0%}; drive turns both ways with steps of a quarter, half and "
            f"all of the torque, each held for {max(2.0 * s.scale, 5.0):.0f} s, for ten minutes"
        )


def _gain_error(grid: Grid, base: Fit) -> float:
    """Relative standard error of the thrust's gain beside a free damping."""
    seen = Projection(grid, base).seen(grid.signals.torque)
    return float(base.sigma / np.sqrt(max(float(seen @ seen), 1e-300)))


def remarks(grid: Grid) -> tuple[str, ...]:
    """Notes on what was declared or recorded, one sentence each with its cure; empty where nothing is odd."""
    if not np.any(grid.signals.torque):
        return ("the torque is zero throughout: if the thrusters were used, its stream is missing",)
    ends, declared = _apparent_inertia(grid), grid.signals.inertia
    if ends is None or ends[0] / FAR <= declared <= FAR * ends[1]:
        return ()
    about = float(np.sqrt(ends[0] * ends[1]))
    return (
        f"torque and acceleration go together as with an inertia of about {about:.3g} kg m²; check the declared "
        f"{declared:.4g} kg m² and whether the torque is in N m",
    )


def _apparent_inertia(grid: Grid) -> tuple[float, float] | None:
    """Between which inertias [kg m²] plain least squares puts the vehicle; None where they cannot say.

    τ = I ṙ + b r + c r|r| + d over cells. Noise in ṙ lowers the I of τ on ṙ, noise in τ raises that of ṙ on τ: the
    truth lies between them (Frisch).
    """
    torque, rate = grid.signals.torque, grid.signals.rate + 0.5 * grid.rise
    drag = np.stack([np.ones(torque.size), rate, rate * np.abs(rate)], axis=1)

    def beside_drag(values: Array) -> Array:
        return np.asarray(values - drag @ np.linalg.lstsq(drag, values)[0])

    slope, left = beside_drag(grid.rise / grid.cell), beside_drag(torque)
    together, square, rest = float(slope @ left), float(slope @ slope), float(left @ left)
    if together <= 0.0 or rest <= 0.0:
        return None
    own = together**2 / (square * rest)
    return (together / square, together / square / own) if own >= OWN else None
