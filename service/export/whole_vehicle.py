"""The model of a whole vehicle as one Python file that needs NumPy alone and simulates as `incsvr` does."""

from __future__ import annotations

from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.terms import Term
from incsvr.vehicle import Vehicle
from incsvr.vehicle.simulation import MAX_STEP_DAMPING, MAX_SUBSTEPS
from service.export.vehicle_remarks import doubts

_MODULE = '''\
"""The motion of {name}: M dv/dt + C(v) v + sum of terms = effort. Written by `incsvr export`; needs NumPy alone.

v = surge, sway, heave [m/s], roll, pitch and yaw rate [rad/s]; effort = forces [N] and moments [N m] in this order;
angle = roll and pitch [rad]. The model holds within FASTEST; beyond, it is a guess.
"""{doubts}

import numpy as np

AXES = {axes!r}
PREDICTED = {rows!r}  # places of the axes whose motion the model predicts; the others stay as they are
M = np.array({mass!r})
THRUST_LAG_S = {lags!r}  # place of the axis -> time constant [s]
FASTEST = {fastest!r}
DECAY = {decay!r}  # largest rate of decay of a velocity within FASTEST [1/s]


def damping(v, effort, angle):
    """What damping, couplings, losses of thrust and restoring moments take of the efforts, (6,)."""
    u, w = v, effort
    roll, pitch = angle
    f = np.zeros(6)
{terms}
    return f


def coriolis(v):
    """C(v) v, (6,), which follows from M."""
    p = M @ v
    return np.concatenate((np.cross(v[3:], p[:3]), np.cross(v[:3], p[:3]) + np.cross(v[3:], p[3:])))


def acceleration(v, effort, angle):
    """dv/dt, (6,)."""
    force = effort - coriolis(v) - damping(v, effort, angle)
    rise = np.zeros(6)
    rise[PREDICTED] = np.linalg.solve(M[np.ix_(PREDICTED, PREDICTED)], force[PREDICTED])
    return rise


def turning(angle, v):
    """Rates of roll and pitch."""
    roll, pitch = angle
    swept = v[4] * np.sin(roll) + v[5] * np.cos(roll)
    return np.array([v[3] + swept * np.tan(pitch), v[4] * np.cos(roll) - v[5] * np.sin(roll)])


def step(v, angle, effort, dt):
    """v and angle after dt [s] under a constant effort, by Runge-Kutta steps of fourth order."""
    count = int(np.clip(np.ceil(dt * DECAY / {max_decay!r}), 1, {max_substeps!r}))
    h = dt / count
    for _ in range(count):
        slopes, at, tilted = [], v, angle
        for ahead in (0.5, 0.5, 1.0, 1.0):
            slope = acceleration(at, effort, tilted), turning(tilted, at)
            slopes.append(slope)
            at, tilted = v + ahead * h * slope[0], angle + ahead * h * slope[1]
        weights = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
        v = v + h * sum(k * slope for k, (slope, _) in zip(weights, slopes))
        angle = angle + h * sum(k * slope for k, (_, slope) in zip(weights, slopes))
    return v, angle


def lagged(effort, dt):
    """(n, 6) mean efforts after the lags of the thrust, from commands that hold for dt [s] each."""
    effort = np.array(effort, dtype=float)
    for place, constant in THRUST_LAG_S.items():
        if constant < 1e-6 * dt:
            continue
        decay, reached = np.exp(-dt / constant), effort[0, place]
        for k, command in enumerate(effort[:, place].copy()):
            effort[k, place] = command + (reached - command) * (constant / dt) * (1.0 - decay)
            reached = command + (reached - command) * decay
    return effort


def free_run(v, efforts, dt, angle=(0.0, 0.0)):
    """(n + 1, 6) velocities from the first ones v (6,) under commands (n, 6) that hold for dt [s] each."""
    v, angle = np.array(v, dtype=float), np.array(angle, dtype=float)
    course = [v]
    for effort in lagged(efforts, dt):
        v, angle = step(v, angle, effort, dt)
        course.append(v)
    return np.array(course)
'''


def python_module(vehicle: Vehicle) -> str:
    """The file's text."""
    structure = vehicle.structure
    lines = [f"    f[{term.row}] += {p.value!r} * {_expression(term)}  # {term.name} [{term.unit}]"
             for term, p in vehicle.terms.items()]  # fmt: skip
    names = list(AXES)
    return _MODULE.format(
        name=vehicle.name.replace("\\", "\\\\").replace('"', '\\"'),
        doubts="".join(f"\n# {each}" for each in doubts(vehicle)),
        axes=names,
        rows=structure.rows,
        mass=vehicle.mass_matrix.tolist(),
        lags={names.index(axis): parameter.value for axis, parameter in vehicle.lags.items()},
        fastest=[float(value) for value in vehicle.fastest],
        decay=vehicle.decay,
        terms="\n".join(lines),
        max_decay=MAX_STEP_DAMPING,
        max_substeps=MAX_SUBSTEPS,
    )


def _expression(term: Term) -> str:
    """φ in the names of the module."""
    own = f"u[{term.row}]"
    of = [f"u[{VELOCITIES.index(name)}]" for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear":
            return own
        case "quadratic":
            return f"{own} * abs({own})"
        case "cross":
            return of[0]
        case "cross_size":
            return f"abs({of[0]}) * {of[1]}"
        case "product":
            return f"{of[0]} * {of[1]}"
        case "square":
            return f"{of[0]} ** 2"
        case "effort":
            return f"-w[{list(AXES).index(term.of[0])}]"
        case "inflow":
            return f"w[{term.row}] * abs({of[0]})"
        case "reverse":
            return f"min(w[{term.row}], 0.0)"
        case "weight":
            down = {"surge": "-np.sin(pitch)", "sway": "np.cos(pitch) * np.sin(roll)"}
            return f"-({down.get(term.axis, 'np.cos(pitch) * np.cos(roll)')})"
        case "righting":
            return "np.cos(pitch) * np.sin(roll)" if term.axis == "roll" else "np.sin(pitch)"
        case _:
            return "1.0"
