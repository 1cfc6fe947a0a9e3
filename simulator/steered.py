"""Leng in the world: as a torque steers it, with its own water, thrusters and sensors; and a beginner's log of it."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant import thruster_torque
from incsvr.signals import TORQUE, YAW_RATE
from service.recordings.recording import Recording, from_streams
from service.recordings.recording_csv import write
from simulator import leng
from simulator.mission import TICK_S, Mission
from simulator.physics import Course, Physics, static
from simulator.plans import OPEN_LOOP, Plan
from simulator.vehicles import TURNING
from simulator.world import Outcome, play

MAX_TORQUE = TURNING["leng"].torque
"""Both thrusters' moment at full speed [N m]."""
LOG_DURATION = 300.0
"""Length of a beginner's log [s]: `fit` learns from it in a second, `trace` in some ten."""
REVERSE_EFFICIENCY = 0.7
"""The part of a moment to port (negative) that the log's vehicle makes of what its rotors' speeds show."""
UNIT_S = leng.INERTIA * leng.MAX_RATE / MAX_TORQUE
"""I r/τ [s]."""
PULL = 2.0 * leng.BOW.lever * leng.BOW.thrust
"""Both thrusters' moment by the rotor speed squared [N m s²/rad²]."""
INFLOW = 2.0 * leng.BOW.lever**2 * leng.BOW.inflow
"""What a turn takes of it, by rotor and yaw rate [N m s²/rad²]."""


def steered(name: str, time: Array, torque: Array, seed: int) -> Recording:
    """Leng, without its hull, as a torque moves it from rest.

    Args:
        name: of the recording.
        time: (n,) stamps [s], increasing.
        torque: (n,) what is asked of the thrusters [N m]; each value holds until the next one.
        seed: draws the water, the wavering of the thrust and the noise of the sensors.

    Raises:
        BadInput: the torque is more than the vehicle has.
    """
    beyond = np.flatnonzero(np.abs(torque) > MAX_TORQUE)
    if beyond.size:
        raise BadInput(
            f"{name}: the torque is {torque[beyond[0]]:g} N m at {time[beyond[0]]:g} s, and the simulated vehicle has "
            f"±{MAX_TORQUE:g} N m; scale the manoeuvre down"
        )
    ticks = np.arange(0.0, max(float(time[-1] - time[0]), TICK_S), TICK_S, dtype=np.float64)
    return at_sea(name, torque[np.searchsorted(time - time[0], ticks, side="right") - 1], seed)[0]


def write_log(path: Path, seed: int) -> float:
    """Writes a beginner's log; returns the vehicle's inertia [kg m²].

    Raises:
        OSError: the file cannot be written.
    """
    write(path, leng_log(path.stem, seed))
    return leng.INERTIA


def leng_log(name: str, seed: int) -> Recording:
    """A beginner's log: Leng steered by steps and sines at once, with weak thrust to port."""
    weak = static(lambda moment: moment if moment > 0.0 else REVERSE_EFFICIENCY * moment)
    told = steps_and_sines(LOG_DURATION, np.random.default_rng([seed, *b"log"]))
    return at_sea(name, told, seed, besides=Physics(stages=(weak,)))[0]


def steps_and_sines(duration: float, random: np.random.Generator) -> Array:
    """Torques at the ticks, levels and several sines at once, so that all commands occur [N m]."""
    time: Array = np.arange(0.0, duration - 1e-9, TICK_S, dtype=np.float64) / UNIT_S
    levels, sines = (OPEN_LOOP[kind](time, random) for kind in ("telegraph", "multisine"))
    return np.asarray(0.5 * MAX_TORQUE * (levels + sines))


def at_sea(
    name: str,
    told: Array,
    seed: int,
    *,
    besides: Physics | None = None,
    hidden: tuple[str, ...] = (),
    onset: float = 0.0,
    hull: bool = False,
) -> tuple[Recording, Outcome]:
    """Leng as its sensors record it, and what truly happened.

    Args:
        name: of the recording.
        told: (n,) what the rotors are told at the ticks, as the moment that it makes at rest [N m].
        seed: draws the water, the wavering, the sensors and the effects.
        besides: what is hidden besides.
        hidden: names of effects that come on.
        onset: when [s].
        hull: whether the hull is mounted.
    """
    for_water, for_sensors = (
        np.random.default_rng(each) for each in np.random.SeedSequence([seed, *b"steered"]).spawn(2)
    )
    own = Physics(losses=(_inflow,), outside=(_lasting(leng.WATER, leng.WATER_MEMORY, told.size, for_water),))
    for share in leng.WAVERING[hull]:
        own += Physics(thrust=(_lasting(0.5 * share, leng.WAVERING_MEMORY, told.size, for_water, 1.0),))
    own += Physics(drag=(lambda t: np.full(t.size, 1.0 + leng.HULL * hull),)) + (besides or Physics())
    outcome = play(
        Mission(
            TURNING["leng"], "holds", seed, hidden, onset=onset, besides=own, beats=1.0 / TICK_S, water=0.0,
            duration=told.size * TICK_S, asked=Plan("torque", told),
        )
    )  # fmt: skip
    return _recorded(name, told, outcome, for_sensors), outcome


def _lasting(size: float, memory: float, ticks: int, random: np.random.Generator, about: float = 0.0) -> Course:
    """A process that lasts, at the ticks and straight between them."""
    values = about + size * leng.lasting(memory, TICK_S, ticks + 1, random)
    time: Array = TICK_S * np.arange(ticks + 1, dtype=np.float64)
    return lambda t: np.interp(t, time, values)


def _inflow(thrust: float, rate: float) -> float:
    """What a turn takes of a moment at rest [N m]."""
    return -INFLOW * sqrt(abs(thrust) / PULL) * rate


def _recorded(name: str, told: Array, outcome: Outcome, random: np.random.Generator) -> Recording:
    """The yaw rate [rad/s], and the torque [N m] that the rotors' speeds make in a vehicle that is sound."""
    time, rate = outcome.time, outcome.true(YAW_RATE)
    gyro = leng.stamps(float(time[-1]), leng.GYRO_PERIOD, random)
    noise = random.normal(0.0, leng.ANGLE_RANDOM_WALK / sqrt(leng.GYRO_PERIOD), gyro.size)
    spin = leng.stamps(float(time[-1]), leng.ROTOR_PERIOD, random)
    speed = np.interp(spin, time, np.sign(told) * np.sqrt(np.abs(told) / PULL))
    speeds = tuple(side * speed + random.normal(0.0, leng.ROTOR_NOISE, spin.size) for side in (1.0, -1.0))
    turn = np.interp(spin, time, rate)
    torque = thruster_torque(leng.THRUSTERS, speeds, tuple(each.lever * turn for each in leng.THRUSTERS))
    streams = {
        YAW_RATE: (gyro, (np.interp(gyro, time, rate) + noise).round(6)),
        TORQUE: (spin, torque.round(4)),
    }
    return from_streams(name, streams)
