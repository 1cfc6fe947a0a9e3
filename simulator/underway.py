"""The demo's third act: Leng with its hull goes on, and under way something breaks that nobody is told of.

A seed draws what comes on (one of EFFECTS, at the sizes of the tracer's trials), when, and how the vehicle is driven:
levels and several sines at once, so that all commands occur. Water, wavering thrust and sensors are those of the
experiment. The streams hold yaw rate and torque alone: the torque as the rotors' told speeds make it in a vehicle that
is sound.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from incsvr.numerics import Array
from incsvr.plant import thruster_torque
from incsvr.signals import TORQUE, YAW_RATE
from service.recordings.recording import Recording, from_streams
from simulator import leng
from simulator.trial_command import Command, command
from simulator.trial_effects import Circumstances, Physics, Scale, Truth, named
from simulator.trial_vehicle import STEP, Motion, Onset, move

EFFECTS = ("dead_zone", "torque_asymmetry", "torque_saturation", "bias_torque", "inertia")
"""What may come on: thrusters that turn at large commands only, or give less astern or at full command; a fin that
bends; a payload. Not thrusters that begin to lag: the checks of the streams take that for a clock that jumped."""
SCALE = Scale(leng.INERTIA, 100.0, leng.MAX_RATE)
DURATION = 800.0
"""[s]"""
SOUND = (60.0, 90.0)
"""For so long all is as it was [s]; the seed draws."""
PULL = 2.0 * leng.BOW.lever * leng.BOW.thrust
"""Both thrusters' moment by the rotor speed squared [N m s²/rad²]."""
INFLOW = 2.0 * leng.BOW.lever**2 * leng.BOW.inflow
"""What a turn takes of it, by rotor and yaw rate [N m s²/rad²]."""


@dataclass(frozen=True, slots=True)
class Underway:
    """The third act as it was played.

    Attributes:
        recording: yaw rate [rad/s] and torque [N m].
        effect: the name of what came on.
        onset: when, on the recording's clock [s].
        truth: its parameters.
    """

    recording: Recording
    effect: str
    onset: float
    truth: Truth


def play(seed: int) -> Underway:
    """The third act that a seed draws."""
    for_effect, for_command, for_water, for_sensors = (
        np.random.default_rng(each) for each in np.random.SeedSequence([seed, *b"underway"]).spawn(4)
    )
    steps = round(DURATION / STEP)
    ticks: Array = np.arange(2 * steps + 1, dtype=np.float64) * STEP / 2.0
    sound = Physics(leng.INERTIA, lambda rate: leng.damping(rate, hull=True), produced=(inflow,))
    effect = str(for_effect.choice(EFFECTS))
    onset = round(for_effect.uniform(*SOUND) / STEP)
    broken, truth = named(effect)(replace(sound, produced=()), Circumstances(SCALE, 1.0, for_effect, ticks))
    broken = replace(broken, produced=(*broken.produced, inflow))
    levels, sines = (command(kind, SCALE, ticks, for_command).table for kind in ("telegraph", "multisine"))
    asked = Command((0.5 * (np.array(levels) + np.array(sines))).tolist())
    told = np.array(asked.table)[: 2 * steps : 2]
    motion = move(sound, asked, water(told, for_water), 0.0, Onset(onset, broken))
    return Underway(recorded("T3", told, motion, for_sensors), effect, onset * STEP, truth)


def recorded(name: str, told: Array, motion: Motion, random: np.random.Generator) -> Recording:
    """A motion of Leng as its sensors record it.

    Args:
        name: of the recording.
        told: (n,) what the rotors were told at the integrator's steps, as the moment that it makes at rest [N m].
        motion: at the same steps.
        random: draws the stamps and the noise of gyro and rotor speeds.

    Returns:
        the yaw rate [rad/s], and the torque [N m] that the rotors' speeds make in a vehicle that is sound.
    """
    last = float(motion.time[-1])
    gyro = leng.stamps(last, leng.GYRO_PERIOD, random)
    noise = random.normal(0.0, leng.ANGLE_RANDOM_WALK / sqrt(leng.GYRO_PERIOD), gyro.size)
    spin = leng.stamps(last, leng.ROTOR_PERIOD, random)
    speed = np.interp(spin, motion.time, np.sign(told) * np.sqrt(np.abs(told) / PULL))
    speeds = tuple(side * speed + random.normal(0.0, leng.ROTOR_NOISE, spin.size) for side in (1.0, -1.0))
    rate = np.interp(spin, motion.time, motion.yaw_rate)
    torque = thruster_torque(leng.THRUSTERS, speeds, tuple(each.lever * rate for each in leng.THRUSTERS))
    streams = {
        YAW_RATE: (gyro, (np.interp(gyro, motion.time, motion.yaw_rate) + noise).round(6)),
        TORQUE: (spin, torque.round(4)),
    }
    return from_streams(name, streams)


def inflow(moment: float, rate: float, _tick: int) -> float:
    """What is left of a moment at rest [N m] when the vehicle turns."""
    return moment + INFLOW * sqrt(abs(moment) / PULL) * rate


def water(told: Array, random: np.random.Generator, hull: bool = True) -> Array:
    """(n,) what moves the vehicle besides, at the integrator's steps: eddies, and thrust that wavers [N m]."""
    moment = leng.WATER * leng.lasting(leng.WATER_MEMORY, STEP, told.size, random)
    for share in leng.WAVERING[hull]:
        moment = moment + 0.5 * share * told * leng.lasting(leng.WAVERING_MEMORY, STEP, told.size, random)
    return np.asarray(moment)
