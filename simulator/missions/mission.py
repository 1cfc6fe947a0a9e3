"""A mission played: a vehicle at work, its controller in the loop, the water, and what the log keeps of it.

At every beat of the controller it reads gyro and compass and says a torque, which is held until the next beat; the
log keeps the gyro that the controller saw and the command, exactly. So the torque answers the water and the gyro's
noise, as it does on real vehicles. Everything follows from the seed, and every kind of chance has a stream of its own:
the same mission with an effect, or with a gyro of its own for the log, is the same in everything else.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.recordings.recording import Recording, Streams, from_streams
from simulator.missions.hidden import hide
from simulator.missions.motion import Motion, sail
from simulator.missions.plans import PLANS, plan
from simulator.missions.vehicles import VEHICLES, Vehicle
from simulator.noise import lasting_noise
from simulator.trial_effects import Circumstances, Physics, Truth
from simulator.trial_effects.physics import Array
from simulator.trial_vehicle import STEP, Onset

KINDS = tuple(PLANS)
GYRO_NOISE = 0.002
"""Deviation of a gyro's white noise [rad/s]."""
COMPASS_NOISE = 0.003
"""Deviation of the compass's white noise [rad]."""
WATER = (0.1 / 18.0, 0.5 / 18.0)
"""The water's moment: its deviation in full torques, from calm to rough."""
WATER_TIME = (0.5, 4.0)
"""Correlation time of the water's moment [s]."""
STILL_RATE = (0.006, 0.014)
"""Rates at which the water turns a vehicle that holds its station [rad/s]."""
DECK_RATE = (0.02, 0.08)
"""Rates at which a ship's deck turns a vehicle [rad/s]."""
RATES = 20
"""In how many rates the range that the commands drive is judged."""
DWELL = 1.0
"""A rate is driven if the vehicle would spend so long near it in still water [s]."""


@dataclass(frozen=True, slots=True)
class Mission:
    """What is played.

    Attributes:
        kind: one of KINDS.
        vehicle: a key of VEHICLES.
        seed: everything that is not said here follows from it.
        effect: what is hidden, by the recording contract's vocabulary; None for nothing.
        effect_size: 1 for its full size.
        onset: when the effect comes on [s].
        water: 1 for water as it usually is, 0 for still water.
        separate_gyro: whether the log's gyro is another than the controller's, with noise and a clock of its own.
        gyro_rate: of a separate gyro [Hz]; None for the controller's rate.
        duration: [s].
        control_rate: of the controller and of what it logs [Hz]; a whole number of integration steps.
    """

    kind: str
    vehicle: str
    seed: int
    effect: str | None = None
    effect_size: float = 1.0
    onset: float = 0.0
    water: float = 1.0
    separate_gyro: bool = False
    gyro_rate: float | None = None
    duration: float = 1800.0
    control_rate: float = 10.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a mission.

    Attributes:
        mission: what was played.
        recording: yaw rate and torque, in every second mission with the heading.
        inertia: what the operator declares [kg m²].
        damping: the true d(r) [N m] at (m,) rates, without what is hidden.
        truth: the hidden effect's parameters.
        water_rms: deviation of the water's moment [N m].
        driven_rates: (m,) the rates that the commands drove [rad/s], evenly spaced but for those that they passed
            over: where the same mission in still water, with sensors free of noise, spends DWELL. Empty where that
            does not turn the vehicle by more than the gyro's noise.
        motion: what truly happened.
        water: (n,) the water's moment at every step [N m].
    """

    mission: Mission
    recording: Recording
    inertia: float
    damping: Callable[[Array], Array]
    truth: Truth
    water_rms: float
    driven_rates: Array
    motion: Motion
    water: Array


def play(mission: Mission, breaking: Callable[[Physics], Physics] | None = None) -> Outcome:
    """Plays a mission.

    Args:
        mission: what is played.
        breaking: makes of the vehicle's equations those of one that breaks under way; None for a sound one.

    Raises:
        KeyError: a kind, vehicle or effect that does not exist.
        ValueError: the controller's period is no whole number of integration steps.
    """
    vehicle = VEHICLES[mission.vehicle]
    hold = round(1.0 / (mission.control_rate * STEP))
    if hold < 1 or not math.isclose(hold * STEP * mission.control_rate, 1.0):
        raise ValueError(f"a control rate of {mission.control_rate} Hz is no whole number of steps of {STEP} s")
    own = [zlib.crc32(name.encode()) for name in (mission.kind, mission.vehicle)]
    draws = [np.random.default_rng(one) for one in np.random.SeedSequence([mission.seed, *own]).spawn(6)]
    for_plan, for_water, for_gyro, for_compass, for_effect, for_log = draws

    beats = round(mission.duration * mission.control_rate)
    steps = beats * hold
    period = hold * STEP
    asked = plan(mission.kind, vehicle, period * np.arange(beats, dtype=np.float64), for_plan)
    rms, time = _water(mission.kind, vehicle, for_water)
    rms *= mission.water
    water = rms * _ornstein_uhlenbeck(steps, time, for_water)
    noise = (
        GYRO_NOISE * for_gyro.standard_normal(beats),
        COMPASS_NOISE * for_compass.standard_normal(beats),
    )
    sound, truth = Physics(vehicle.scale.inertia, vehicle.drag), Truth()
    if breaking is not None:
        sound = breaking(sound)
    physics = sound
    if mission.effect is not None:
        ticks = np.arange(2 * steps + 1, dtype=np.float64) * STEP / 2.0
        here = Circumstances(vehicle.scale, mission.effect_size, for_effect, ticks)
        physics, truth = hide(mission.effect, sound, vehicle, here)
    onset = Onset(round(mission.onset / STEP), physics) if mission.onset else None
    physics = physics if onset is None else sound

    quiet = np.zeros(beats)
    undisturbed = sail(physics, vehicle, asked, hold, np.zeros(steps), (quiet, quiet), onset)
    if mission.kind == "on_deck":
        motion = _carried(steps, hold, noise, for_water)
    else:
        motion = sail(physics, vehicle, asked, hold, water, noise, onset)
    return Outcome(
        mission=mission,
        recording=from_streams(
            f"{mission.kind}_{mission.vehicle}_{mission.seed}", _log(mission, motion, period, for_log)
        ),
        inertia=vehicle.scale.inertia,
        damping=lambda rates: np.array([vehicle.drag(rate) for rate in np.asarray(rates).tolist()]),
        truth=truth,
        water_rms=rms,
        driven_rates=_driven(undisturbed.yaw_rate),
        motion=motion,
        water=water,
    )


def _water(kind: str, vehicle: Vehicle, random: np.random.Generator) -> tuple[float, float]:
    """Deviation [N m] and correlation time [s] of the water's moment; calm where a station is held."""
    time = float(np.exp(random.uniform(*np.log(WATER_TIME))))
    rms = vehicle.scale.torque * random.uniform(*WATER)
    if kind == "station":
        # The rate of an Ornstein-Uhlenbeck moment through I ṙ + d' r, solved for the moment.
        response_time = vehicle.scale.inertia / vehicle.linear_drag
        rms = random.uniform(*STILL_RATE) * vehicle.linear_drag * math.sqrt(1.0 + response_time / time)
    return float(rms), time


def _ornstein_uhlenbeck(count: int, time: float, random: np.random.Generator) -> Array:
    """(count,) values one integration step apart, of deviation one."""
    kept = math.exp(-STEP / time)
    kicks = math.sqrt(1.0 - kept**2) * random.standard_normal(count)
    return lasting_noise(float(random.standard_normal()), kept, kicks)


def _carried(steps: int, hold: int, noise: tuple[Array, Array], random: np.random.Generator) -> Motion:
    """A deck that yaws; nothing that the vehicle could do changes it."""
    rates = random.uniform(*DECK_RATE) * _ornstein_uhlenbeck(steps, random.uniform(1.0, 4.0), random)
    headings = np.concatenate([[0.0], np.cumsum(STEP * rates[:-1])])
    gyro, compass = rates[::hold] + noise[0], headings[::hold] + noise[1]
    return Motion(STEP * np.arange(steps, dtype=np.float64), rates, headings, gyro, compass, np.zeros(gyro.size))


def _log(mission: Mission, motion: Motion, period: float, random: np.random.Generator) -> Streams:
    time = np.round(period * np.arange(motion.command.size), 6)
    streams: Streams = {"yaw_rate": (time, motion.gyro), "torque": (time, motion.command)}
    with_heading = random.random() < 0.5
    if mission.separate_gyro:
        own = period if mission.gyro_rate is None else 1.0 / mission.gyro_rate
        count = int(time[-1] / own)
        stamps = np.round(own * np.arange(count, dtype=np.float64) + random.uniform(0.0, own), 6)
        rate = np.interp(stamps, motion.time, motion.yaw_rate)
        streams["yaw_rate"] = (stamps, rate + GYRO_NOISE * random.standard_normal(stamps.size))
    if with_heading:
        streams["heading"] = (time, (motion.compass + math.pi) % (2.0 * math.pi) - math.pi)
    return streams


def _driven(rate: Array) -> Array:
    """The driven rates of a motion in still water [rad/s]."""
    if np.abs(rate).max() < 2.0 * GYRO_NOISE:
        return np.empty(0)
    times, edges = np.histogram(rate, RATES)
    return np.asarray(0.5 * (edges[1:] + edges[:-1])[STEP * times >= DWELL])
