"""Whole vehicles in six degrees of freedom that move under random commands, to test what is identified from them.

Fossen's equations (Handbook of Marine Craft Hydrodynamics and Motion Control, 2011), written anew:
M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r + g(η) = τ, with ν_r the velocity through the water and a constant current.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Log = dict[str, tuple[Array, Array]]
"""Times [s] and values of each stream by its name."""

NAMES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
RATES = ("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")
EFFORTS = ("surge_force", "sway_force", "heave_force", "roll_torque", "pitch_torque", "torque")
STEP_S = 0.02
"""Step of the integration [s]: a fiftieth of the quickest vehicle's time constant."""
LOG_EVERY = 5
"""Steps between two rows of the log: 10 Hz."""


@dataclass(frozen=True, slots=True)
class Body:
    """A vehicle.

    Attributes:
        moves: names of the axes that move; the others are held at zero.
        mass: (6, 6) inertia with added mass.
        linear, quadratic: (6,) damping [N s/m], [N s²/m²], … of each axis.
        righting: moment of weight and buoyancy about roll and pitch [N m].
        effort: axis → the largest effort of its commands [N], [N m].
        hold_s: how long a command holds, shortest and longest [s].
    """

    moves: tuple[str, ...]
    mass: Array
    linear: Array
    quadratic: Array
    righting: float
    effort: Mapping[str, float]
    hold_s: tuple[float, float]


def rov(rng: np.random.Generator) -> Body:
    """A small ROV with eight thrusters, all axes driven."""
    mass = np.diag([18.0, 24.0, 28.0, 0.28, 0.32, 0.6]) * _draw(rng)
    mass[0, 4] = mass[4, 0] = 0.4 * rng.uniform(0.5, 1.5)
    mass[1, 3] = mass[3, 1] = -0.4 * rng.uniform(0.5, 1.5)
    linear = np.array([8.0, 12.0, 14.0, 0.3, 0.4, 0.5]) * _draw(rng)
    quadratic = np.array([35.0, 60.0, 75.0, 0.5, 0.6, 0.9]) * _draw(rng)
    effort = {"surge": 40.0, "sway": 40.0, "heave": 40.0, "roll": 2.0, "pitch": 2.0, "yaw": 4.0}
    return Body(NAMES, mass, linear, quadratic, 4.0 * rng.uniform(0.8, 1.2), effort, (0.6, 3.0))


def torpedo(rng: np.random.Generator) -> Body:
    """A torpedo of 1.6 m in the horizontal plane, driven along surge, and by lateral and yaw thrusters."""
    mass = np.diag([32.0, 66.0, 66.0, 0.3, 8.0, 8.0]) * _draw(rng)
    mass[1, 5] = mass[5, 1] = 1.5 * rng.uniform(-1.0, 1.0)
    linear = np.array([3.0, 18.0, 18.0, 0.5, 5.0, 5.0]) * _draw(rng)
    quadratic = np.array([4.0, 120.0, 120.0, 0.5, 30.0, 30.0]) * _draw(rng)
    effort = {"surge": 12.0, "sway": 25.0, "yaw": 8.0}
    return Body(("surge", "sway", "yaw"), mass, linear, quadratic, 0.0, effort, (2.0, 10.0))


def boat(rng: np.random.Generator) -> Body:
    """A boat with two thrusters, whose sway nothing drives."""
    mass = np.diag([45.0, 80.0, 1.0, 1.0, 1.0, 25.0]) * _draw(rng)
    mass[1, 5] = mass[5, 1] = 3.0 * rng.uniform(-1.0, 1.0)
    linear = np.array([8.0, 60.0, 1.0, 1.0, 1.0, 15.0]) * _draw(rng)
    quadratic = np.array([12.0, 150.0, 1.0, 1.0, 1.0, 60.0]) * _draw(rng)
    return Body(("surge", "sway", "yaw"), mass, linear, quadratic, 0.0, {"surge": 60.0, "yaw": 18.0}, (1.0, 6.0))


BODIES = {"rov": rov, "torpedo": torpedo, "boat": boat}


@dataclass(frozen=True, slots=True)
class Sensors:
    """White noise of the log: velocities [m/s], angular velocities [rad/s]."""

    along: float = 0.005
    about: float = 0.003


def swim(
    body: Body,
    seconds: float,
    rng: np.random.Generator,
    current: tuple[float, float] = (0.0, 0.0),
    sensors: Sensors | None = None,
    water: float = 0.02,
) -> Log:
    """The log of a dive: streams of velocities over ground, efforts, roll, pitch and heading by name.

    Args:
        seconds: length of the dive [s].
        current: velocity of the water to north and east [m/s].
        sensors: noise; None for the usual.
        water: RMS of a slowly varying disturbance of each axis, in its largest effort.
    """
    return swim_together([body], seconds, rng, current, sensors, water)[0]


def swim_together(
    bodies: Sequence[Body],
    seconds: float,
    rng: np.random.Generator,
    current: tuple[float, float] = (0.0, 0.0),
    sensors: Sensors | None = None,
    water: float = 0.02,
) -> list[Log]:
    """The logs of dives of equal length, which cost little more than one; arguments as of `swim`."""
    sensors = Sensors() if sensors is None else sensors
    count = int(seconds / STEP_S)
    moving = np.array([[name in body.moves for name in NAMES] for body in bodies])
    effort, push = np.zeros((count, len(bodies), 6)), np.zeros((count, len(bodies), 6))
    for k, body in enumerate(bodies):
        for name, largest in body.effort.items():
            effort[:, k, NAMES.index(name)] = _commands(count, largest, body.hold_s, rng)
        full = np.array([body.effort.get(name, 0.3 * max(body.effort.values())) for name in NAMES])
        push[:, k] = effort[:, k] + _slow(count, rng) * water * full * moving[k]
    each = _Bodies.of(bodies, moving)
    state, angles = np.zeros((len(bodies), 6)), np.zeros((len(bodies), 3))
    rows = []
    for k in range(count):
        if k % LOG_EVERY == 0:
            over_ground = state.copy()
            over_ground[:, :3] += _in_body(angles, np.array([*current, 0.0]))
            rows.append(np.concatenate((over_ground, effort[k], angles), axis=1))
        state, angles = _step(each, state, angles, push[k])
    tables = np.stack(rows, axis=1)
    noise = np.where(np.arange(6) < 3, sensors.along, sensors.about)
    tables[..., :6] += noise * rng.standard_normal((*tables.shape[:2], 6))
    return [_log(body, table, moves) for body, table, moves in zip(bodies, tables, moving, strict=True)]


def _log(body: Body, table: Array, moving: NDArray[np.bool_]) -> Log:
    """The streams of a table (n, 15) of velocities, efforts and angles."""
    time: Array = np.asarray(STEP_S * LOG_EVERY * np.arange(table.shape[0]), dtype=np.float64)
    streams = {name: (time, table[:, k]) for k, name in enumerate(RATES) if moving[k]}
    streams |= {EFFORTS[NAMES.index(name)]: (time, table[:, 6 + NAMES.index(name)]) for name in body.effort}
    angle_names = ("roll", "pitch", "heading")
    streams |= {name: (time, table[:, 12 + k]) for k, name in enumerate(angle_names) if k == 2 or moving[3 + k]}
    return streams


def _draw(rng: np.random.Generator) -> Array:
    return rng.uniform(0.7, 1.3, 6)


def _commands(count: int, largest: float, hold_s: tuple[float, float], rng: np.random.Generator) -> Array:
    """Levels that hold for a while each, and change at a beat of the log, as a controller's do."""
    found = np.empty(count)
    k = 0
    while k < count:
        length = LOG_EVERY * max(1, int(rng.uniform(*hold_s) / (LOG_EVERY * STEP_S)))
        found[k : k + length] = rng.uniform(-largest, largest)
        k += length
    return found


def _slow(count: int, rng: np.random.Generator) -> Array:
    """(count, 6) Ornstein–Uhlenbeck processes of unit variance and 1 s."""
    keep = np.exp(-STEP_S / 1.0)
    noise = rng.standard_normal((count, 6)) * np.sqrt(1.0 - keep**2)
    found = np.empty((count, 6))
    value = rng.standard_normal(6)
    for k in range(count):
        value = keep * value + noise[k]
        found[k] = value
    return found


@dataclass(frozen=True, slots=True)
class _Bodies:
    """Several bodies.

    Attributes:
        moving: (bodies, 6) whether an axis moves.
        mass, inverse: (bodies, 6, 6) inertia of the axes that move, zero elsewhere, and its inverse there.
        linear, quadratic: (bodies, 6) damping.
        righting: (bodies,) [N m].
    """

    moving: NDArray[np.bool_]
    mass: Array
    inverse: Array
    linear: Array
    quadratic: Array
    righting: Array

    @staticmethod
    def of(bodies: Sequence[Body], moving: NDArray[np.bool_]) -> _Bodies:
        mass = np.stack([body.mass for body in bodies]) * moving[:, :, None] * moving[:, None, :]
        inverse: Array = np.asarray(np.linalg.inv(mass + np.eye(6) * ~moving[:, :, None]), dtype=np.float64)
        inverse = inverse * moving[:, :, None] * moving[:, None, :]
        linear, quadratic = (np.stack([getattr(body, name) for body in bodies]) for name in ("linear", "quadratic"))
        return _Bodies(moving, mass, inverse, linear, quadratic, np.array([body.righting for body in bodies]))


def _step(bodies: _Bodies, state: Array, angles: Array, push: Array) -> tuple[Array, Array]:
    """One step of the midpoint rule."""
    half = state + 0.5 * STEP_S * _rise(bodies, state, angles, push)
    tilted = angles + 0.5 * STEP_S * _spin(angles, state)
    state = state + STEP_S * _rise(bodies, half, tilted, push)
    return state, angles + STEP_S * _spin(tilted, half)


def _rise(bodies: _Bodies, v: Array, angles: Array, push: Array) -> Array:
    """ν̇_r (bodies, 6)."""
    momentum = np.einsum("bij,bj->bi", bodies.mass, v)
    force = push - bodies.linear * v - bodies.quadratic * np.abs(v) * v
    force[:, :3] -= _cross(v[:, 3:], momentum[:, :3])
    force[:, 3:] -= _cross(v[:, :3], momentum[:, :3]) + _cross(v[:, 3:], momentum[:, 3:])
    force[:, 3] -= bodies.righting * np.cos(angles[:, 1]) * np.sin(angles[:, 0])
    force[:, 4] -= bodies.righting * np.sin(angles[:, 1])
    found: Array = np.einsum("bij,bj->bi", bodies.inverse, force)
    return found


def _cross(a: Array, b: Array) -> Array:
    """a × b, (bodies, 3)."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _spin(angles: Array, v: Array) -> Array:
    """Rates of roll, pitch and heading (bodies, 3)."""
    roll, pitch = angles[:, 0], np.clip(angles[:, 1], -1.4, 1.4)
    p, q, r = v[:, 3:].T
    swept = q * np.sin(roll) + r * np.cos(roll)
    rates = [p + swept * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll), swept / np.cos(pitch)]
    return np.stack(rates, axis=1)


def _in_body(angles: Array, vector: Array) -> Array:
    """(bodies, 3) a vector of north, east and down along the axes of each body."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles).T, np.sin(angles).T
    rotation = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    found: Array = np.einsum("ijb,i->bj", rotation, vector)
    return found
