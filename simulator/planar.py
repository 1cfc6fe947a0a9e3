"""A vehicle in the plane whose damping couples surge, sway and yaw: what damping of several velocities is tried on.

Of Leng's size, with a fin at the stern. The hull's drag is the textbook's, to second order (Fossen 2011, Section 6.4),
and damps a turn the more the faster the vehicle goes. The fin is not of second order: it meets the water at its own
angle α = atan2(v − l r, |u|), lifts as sin 2α, stalls, and drags as sin² α. The seed draws every size, so that no table
is one vehicle's, and nothing here is shared with what learns.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, sin

import numpy as np

from incsvr.numerics import Array
from service.recordings.recording import Recording, from_streams
from simulator.leng import lasting, stamps

STEP = 0.02
"""Step of Heun's integration [s]; the shortest time scale is a second."""
SPREAD = 0.25
"""Each size is drawn within this part of its usual value."""
USUAL = {
    "surge_mass": 900.0,  # kg, with added mass
    "sway_mass": 1400.0,
    "inertia": 350.0,  # kg m²
    "surge_drag": 90.0,  # N s²/m²
    "sway_drag": 500.0,
    "yaw_linear": 90.0,  # N m s/rad
    "yaw_quadratic": 900.0,  # N m s²/rad²
    "yaw_with_speed": 160.0,  # N m s²/(rad m), of r|u|
    "fin": 230.0,  # N s²/m², ½ρ A C_L'
    "lever": 1.1,  # m, from the origin back to the fin
}
THRUST = ((-60.0, 260.0), (-90.0, 90.0), (-75.0, 75.0))
"""Ranges of the commands of surge [N], sway [N] and yaw [N m], which are drawn evenly."""
HOLD = ((15.0, 40.0), (6.0, 15.0), (3.0, 9.0))
"""For how long a command holds [s], evenly between these."""
WATER = (15.0, 15.0, 3.3)
"""Deviation of what the water pushes with [N], [N], [N m]: of yaw as of Leng."""
WATER_MEMORY = 0.45
GYRO, DVL, TORQUE = (0.05, 3e-4), (0.1, 0.01), (0.05, 0.3)
"""Period [s] and noise of the yaw rate [rad/s], of surge and sway [m/s] and of force and torque [N], [N m]."""


@dataclass(frozen=True, slots=True)
class Planar:
    """One vehicle; the attributes are those of USUAL."""

    surge_mass: float
    sway_mass: float
    inertia: float
    surge_drag: float
    sway_drag: float
    yaw_linear: float
    yaw_quadratic: float
    yaw_with_speed: float
    fin: float
    lever: float

    @staticmethod
    def drawn(seed: int) -> Planar:
        rng = np.random.default_rng([seed, 0])
        return Planar(**{name: usual * rng.uniform(1.0 - SPREAD, 1.0 + SPREAD) for name, usual in USUAL.items()})

    def damping(self, u: float, v: float, r: float) -> tuple[float, float, float]:
        """Force along surge and sway [N] and moment about yaw [N m] that damp; the fin turns by −l times its force."""
        at_fin = v - self.lever * r
        angle, square = atan2(at_fin, abs(u)), u * u + at_fin * at_fin
        side = self.fin * square * (0.5 * sin(2.0 * angle) + sin(angle) * abs(sin(angle)))
        surge = u * (10.0 + self.surge_drag * abs(u)) + 0.3 * side * sin(angle) * (1.0 if u > 0.0 else -1.0)
        sway = v * (40.0 + self.sway_drag * hypot(v, 0.3 * u)) + side
        yaw = r * (self.yaw_linear + self.yaw_quadratic * abs(r) + self.yaw_with_speed * abs(u)) - self.lever * side
        return surge, sway, yaw

    def munk(self, u: float, v: float) -> float:
        """(C(ν) ν)_r [N m], which counts as damping where no mass matrix is declared."""
        return (self.sway_mass - self.surge_mass) * u * v


DEFAULT = Planar(**USUAL)
"""What `incsvr simulate` plays: the inertia is that of the default configuration."""


def truth(vehicle: Planar, u: Array, v: Array, r: Array, with_munk: bool) -> Array:
    """d(ν) about yaw, (n,) [N m], with or without Munk's moment."""
    found = [
        vehicle.damping(*each)[2] + (vehicle.munk(each[0], each[1]) if with_munk else 0.0)
        for each in zip(u.tolist(), v.tolist(), r.tolist(), strict=True)
    ]
    return np.array(found)


def recording(seed: int, duration: float = 600.0, run: int = 1, vehicle: Planar | None = None) -> Recording:
    """A run as a vehicle would record it, that of the seed unless one is given; `run` draws commands, water, noise."""
    vehicle, rng = vehicle or Planar.drawn(seed), np.random.default_rng([seed, run])
    steps = round(duration / STEP)
    time: Array = STEP * np.arange(steps + 1, dtype=np.float64)
    commands = [_held(low, high, hold, steps, rng) for (low, high), hold in zip(THRUST, HOLD, strict=True)]
    water = [size * lasting(WATER_MEMORY, STEP, steps, rng) for size in WATER]
    pushed = [(one + other).tolist() for one, other in zip(commands, water, strict=True)]
    u, v, r = 0.0, 0.0, 0.0
    motion = [(u, v, r)]
    for push in zip(*pushed, strict=True):
        first = _acceleration(vehicle, (u, v, r), push)
        halfway = (u + STEP * first[0], v + STEP * first[1], r + STEP * first[2])
        second = _acceleration(vehicle, halfway, push)
        u, v, r = (x + 0.5 * STEP * (a + b) for x, a, b in zip((u, v, r), first, second, strict=True))
        motion.append((u, v, r))
    velocity = np.array(motion).T
    columns = {"surge": velocity[0], "sway": velocity[1], "yaw_rate": velocity[2]}
    streams = {
        name: _measured(time, values, *(GYRO if name == "yaw_rate" else DVL), duration, rng)
        for name, values in columns.items()
    }
    for name, command in zip(("surge_force", "sway_force", "torque"), commands, strict=True):
        streams[name] = _measured(time, np.append(command, command[-1]), *TORQUE, duration, rng)
    return from_streams(f"planar-{seed}-{run}", streams)


def _acceleration(
    vehicle: Planar, velocity: tuple[float, float, float], push: tuple[float, ...]
) -> tuple[float, float, float]:
    """u̇, v̇, ṙ of M ν̇ + C(ν) ν + d(ν) = τ with a diagonal M."""
    u, v, r = velocity
    surge, sway, yaw = vehicle.damping(u, v, r)
    return (
        (push[0] - surge + vehicle.sway_mass * v * r) / vehicle.surge_mass,
        (push[1] - sway - vehicle.surge_mass * u * r) / vehicle.sway_mass,
        (push[2] - yaw - vehicle.munk(u, v)) / vehicle.inertia,
    )


def _held(low: float, high: float, hold: tuple[float, float], steps: int, rng: np.random.Generator) -> Array:
    """(steps,) levels between low and high, each held for a time [s], with a rotor's lag of 0.15 s."""
    levels = np.empty(0)
    while levels.size < steps:
        levels = np.append(levels, np.full(round(rng.uniform(*hold) / STEP), rng.uniform(low, high)))
    share, value, found = STEP / 0.15, 0.0, []
    for level in levels[:steps].tolist():
        value += share * (level - value)
        found.append(value)
    return np.array(found)


def _measured(
    time: Array, value: Array, period: float, noise: float, duration: float, rng: np.random.Generator
) -> tuple[Array, Array]:
    at = stamps(duration, period, rng)
    return at, (np.interp(at, time, value) + noise * rng.normal(size=at.size)).round(6)
