"""An identified vehicle at sea again: the model of a vehicle file, driven by the efforts of a log."""

from __future__ import annotations

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams, cell_means
from incsvr.plant.attitude import ATTITUDE, kinematics
from incsvr.plant.axes import AXES, EFFORTS
from incsvr.vehicle import Vehicle
from incsvr.vehicle.runs import is_held
from service.recordings.recording import Recording

MAX_STEP_S = 0.02
"""Longest step between two values that are played [s]: a vehicle's gyro tells 50 a second and more."""


def moved_by(log: Streams, vehicle: Vehicle, name: str) -> Recording:
    """The recording of what a vehicle does from rest under the efforts of a log: velocities, roll, pitch, efforts.

    The heading is left out, because no learner needs it.

    Args:
        log: streams by the names of recordings, of which the efforts along driven axes are taken.
        vehicle: the model.
        name: of the recording.

    Raises:
        BadInput: the log holds no effort that drives the vehicle.
    """
    efforts = {AXES[name].effort: log[AXES[name].effort] for name in vehicle.driven if AXES[name].effort in log}
    efforts = {name: stream for name, stream in efforts.items() if stream[0].size > 1}
    if not efforts:
        wanted = " ".join(f"--column {AXES[name].effort}=NAME" for name in vehicle.driven)
        raise BadInput(f"the log holds no effort that drives {vehicle.name}; name those that it holds: {wanted}")
    step = min(MAX_STEP_S, *(float(np.median(np.diff(time))) for time, _ in efforts.values()))
    first = min(float(time[0]) for time, _ in efforts.values())
    last = max(float(time[-1]) for time, _ in efforts.values())
    edges: Array = first + step * np.arange(int((last - first) / step) + 1, dtype=np.float64)
    drive = np.zeros((edges.size - 1, 6))
    for effort, (time, values) in efforts.items():
        drive[:, EFFORTS.index(effort)] = cell_means(time, values, edges, is_held(values))
    drives = {AXES[name].effort: (edges[:-1], drive[:, _place(name)]) for name in vehicle.driven}
    _, velocity = vehicle.free_run(drives, held=True)
    angle = _attitude(velocity, step)
    found = {AXES[axis].rate: (edges[:-1], velocity[:, _place(axis)]) for axis in vehicle.axes}
    found |= {each: (edges[:-1], angle[:, k]) for k, each in enumerate(ATTITUDE)}
    # The mean of a cell is what acts in its middle.
    middle = edges[:-1] + 0.5 * step
    return Recording(name, found | {AXES[axis].effort: (middle, drive[:, _place(axis)]) for axis in vehicle.driven})


def _attitude(velocity: Array, step: float) -> Array:
    """Roll, pitch and heading (n, 3) [rad] under velocities (n, 6), by Heun's method."""
    angle = np.zeros((velocity.shape[0], 3))
    for k in range(velocity.shape[0] - 1):
        begin = _turning(angle[k], velocity[k])
        end = _turning(angle[k] + step * begin, velocity[k + 1])
        angle[k + 1] = angle[k] + 0.5 * step * (begin + end)
    return angle


def _turning(angle: Array, velocity: Array) -> Array:
    """Rates of roll, pitch and heading [rad/s]."""
    return np.asarray((kinematics(*angle.tolist()) @ velocity)[3:])


def _place(axis: str) -> int:
    return list(AXES).index(axis)
