"""Recordings of the simulated world, as tests need them; each is played once a session."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.signal import lfilter

from incsvr.numerics import Streams
from incsvr.tracing.run import Run
from service.recordings.recording import Recording
from simulator import vehicles
from simulator.dive_log import dives
from simulator.mission import Mission
from simulator.plans import Plan
from simulator.sensors import Sensor, own_clocks, torque_sensor
from simulator.vehicles import TURNING
from simulator.world import Outcome, play
from tests import planar as planar_vehicle

ROV = TURNING["rov"]
"""A small vehicle: 0.6 kg m², d(r) = 0.6 r + 1.6 r|r|."""


@cache
def mission(kind: str, vehicle: str, seed: int, duration: float = 1800.0, hidden: tuple[str, ...] = ()) -> Outcome:
    """An ordinary mission: gyro and compass at the controller's beats."""
    return play(Mission(TURNING[vehicle], kind, seed, hidden, duration=duration))


def of_trial(
    seed: int,
    hidden: tuple[str, ...] = (),
    vehicle: str = "leng",
    kind: str = "telegraph",
    duration: float = 360.0,
    *,
    measured: bool = True,
    channels: tuple[str, ...] = (),
    size: float = 1.0,
) -> Mission:
    """A vehicle under an excitation, with sensors on clocks of their own and, where it is measured, a torque sensor."""

    def sensing(of: vehicles.Vehicle, random: np.random.Generator) -> tuple[Sensor, ...]:
        return (*own_clocks(of, random), torque_sensor(of, random)) if measured else own_clocks(of, random)

    beats = 25.0 if vehicle == "small" else 10.0
    return Mission(
        TURNING[vehicle], kind, seed, hidden, size=size, duration=duration, beats=beats, sensing=sensing,
        channels=channels,
    )  # fmt: skip


@cache
def trial(seed: int, *words: Any, **further: Any) -> Outcome:
    """What `of_trial` describes, played."""
    return play(of_trial(seed, *words, **further))


def as_run(recording: Recording) -> Run:
    """The recording as the tracer takes it."""
    columns = dict(recording.columns)
    return Run(recording.name, recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)


@cache
def slow(seed: int, every: float, changes: tuple[float, float] = (0.8, 2.4), duration: float = 420.0) -> Recording:
    """ROV under commands that hold for between so long [s], of which a message comes every so many seconds, sampled on
    a clock of its own; a gyro at 20 Hz with a noise of 0.003 rad/s."""
    random = np.random.default_rng(seed)
    ends = np.cumsum(random.uniform(*changes, int(duration / changes[0]) + 2))
    levels = random.uniform(-8.0, 8.0, ends.size).round(3)
    beats = np.arange(0.0, duration - 1e-9, 0.02)
    asked = Plan("torque", levels[np.searchsorted(ends, beats, side="right")])
    sensors = (Sensor("yaw_rate", 20.0, 0.003, phase=0.0), Sensor("torque", 1.0 / every, phase=0.5))
    return play(
        Mission(
            ROV, "holds", seed, beats=50.0, duration=duration, asked=asked, water=0.0, sensing=lambda *_: sensors
        )
    ).recording  # fmt: skip


PLANAR_LEVELS = {"surge": (-60.0, 260.0, 15.0, 40.0), "sway": (-90.0, 90.0, 6.0, 15.0), "yaw": (-75.0, 75.0, 3.0, 9.0)}
"""Ranges of the efforts of a planar vehicle [N], [N m], and of how long one holds [s]."""


@cache
def planar(seed: int, duration: float = 400.0, run: int = 1, usual: bool = False) -> Recording:
    """A vehicle in the plane, whose damping couples surge, sway and yaw, under efforts that hold, with rotors' lag."""
    random = np.random.default_rng([seed, run])
    asked = {}
    for axis, (low, high, shortest, longest) in PLANAR_LEVELS.items():
        ends = np.cumsum(random.uniform(shortest, longest, int(duration / shortest) + 2))
        levels = random.uniform(low, high, ends.size)
        beats = np.arange(0.0, duration - 1e-9, 0.02)
        held = levels[np.searchsorted(ends, beats, side="right")]
        asked[axis] = np.asarray(lfilter([0.02 / 0.15], [1.0, 0.02 / 0.15 - 1.0], held))

    def sensing(*_: object) -> tuple[Sensor, ...]:
        about = Sensor("yaw_rate", 20.0, 3e-4, jitter=0.05)
        along = [Sensor(name, 10.0, 0.01, jitter=0.05) for name in ("surge", "sway")]
        efforts = [Sensor(name, 20.0, 0.3, jitter=0.05) for name in ("surge_force", "sway_force", "torque")]
        return (about, *along, *efforts)

    plan = Plan("torque", asked.pop("yaw"), others=asked)
    vehicle = planar_vehicle.PLANAR if usual else planar_vehicle.planar(seed)
    return play(
        Mission(vehicle, "holds", seed + 1000 * run, duration=duration, beats=50.0, sensing=sensing, asked=plan)
    ).recording


def swim(vehicle: vehicles.Vehicle, seconds: float, seed: int, current: tuple[float, float] = (0.0, 0.0)) -> Streams:
    """The log of a dive under commands that hold."""
    (log,) = dives([vehicle], seconds, seed, current)
    return log
