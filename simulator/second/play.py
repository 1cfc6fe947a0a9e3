"""One case of the second simulator, played to its recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.recordings.recording import Recording, from_streams
from simulator.second.channels import CHANNELS, wandering
from simulator.second.commands import COMMANDS, computer_period, pilot_of, usual_swing
from simulator.second.hidden import BY_CHANNEL, EFFECTS, hide
from simulator.second.motion import Motion, motion_of
from simulator.second.plant import STEP, Array, Parameters, Plant, Setting
from simulator.second.sensors import clocked, logged_course, measured_torque
from simulator.second.vehicles import VEHICLES, Vehicle


@dataclass(frozen=True, slots=True)
class Case:
    """What a run is made of; all else follows from the seed.

    Attributes:
        seed: of every chance.
        vehicle: one of VEHICLES.
        command: one of COMMANDS.
        torque: whether the command is logged as it was given, or measured with noise.
        effects: names of CONTRACT §5; those with a channel need it in `channels`.
        size: of the effects; 1 is realistic.
        channels: further channels that are recorded, whether or not an effect comes with them.
        compass: whether the heading is logged.
        duration: [s].
    """

    seed: int
    vehicle: str
    command: str
    torque: Literal["commanded", "measured"] = "commanded"
    effects: tuple[str, ...] = ()
    size: float = 1.0
    channels: tuple[str, ...] = ()
    compass: bool = True
    duration: float = 720.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """A case's recording and the truth about it.

    Attributes:
        recording: as a vehicle would log it.
        inertia: what its operator declares [kg m²].
        truth: the true parameters of each hidden effect, by its name.
        motion: what truly happened.
    """

    recording: Recording
    inertia: float
    truth: Mapping[str, Parameters]
    motion: Motion


def chance(case: Case, kind: str) -> np.random.Generator:
    """The chance of one kind of thing: none takes from another, so that what is added changes nothing beside it."""
    return np.random.default_rng(np.random.SeedSequence([case.seed, *kind.encode()]))


def play(case: Case) -> Outcome:
    """The recording of a case, and the truth about it.

    Raises:
        ValueError: the case names what there is not.
    """
    _check(case)
    vehicle = VEHICLES[case.vehicle]
    period = computer_period(vehicle, chance(case, "computer"))
    hold = round(period / STEP)
    ticks = int(case.duration / period)
    time = STEP * np.arange(ticks * hold, dtype=np.float64)
    courses = {name: CHANNELS[name](time, vehicle.time_scale, chance(case, name)) for name in case.channels}
    plant = Plant(
        inertia=vehicle.inertia,
        drag=vehicle.drag(),
        drag_factor=np.ones(time.size),
        thrust_factor=np.ones(time.size),
        outside=water(vehicle, time.size, chance(case, "water")),
    )
    # Whoever has no compass counts from zero.
    start = float(chance(case, "start").uniform(-np.pi, np.pi)) if case.compass else 0.0
    truth = {}
    for name in case.effects:
        setting = Setting(
            vehicle.full_torque, vehicle.full_rate, vehicle.time_scale, start,
            usual_swing(case.command, vehicle, case.duration), case.size, chance(case, name), time, courses,
        )  # fmt: skip
        plant, truth[name] = hide(plant, name, setting)

    length, full_rate = ticks * period, vehicle.full_rate
    gyro = clocked(length, (20.0, 50.0), (0.003 * full_rate, 0.01 * full_rate), chance(case, "gyro"))
    compass = clocked(length, (5.0, 10.0), (0.002, 0.006), chance(case, "compass")) if case.compass else None
    stamps = period * np.arange(ticks, dtype=np.float64)
    pilot = pilot_of(case.command, vehicle, stamps, start, chance(case, "command"))
    motion = motion_of(plant, pilot, hold, gyro, compass, (0.0, start))

    torque = (stamps, motion.command)
    if case.torque == "measured":
        torque = measured_torque(motion.command, period, vehicle.full_torque, chance(case, "torque"))
    streams = {"yaw_rate": (gyro.stamps, motion.gyro), "torque": torque}
    if compass is not None:
        streams["heading"] = (compass.stamps, motion.compass)
    for name, course in courses.items():
        streams[name] = logged_course(course, (2.0, 15.0), chance(case, f"logged {name}"))
    return Outcome(from_streams(f"second-{case.seed}", streams), vehicle.inertia, truth, motion)


def water(vehicle: Vehicle, count: int, random: np.random.Generator) -> Array:
    """(count,) the moment by which moving water really turns the vehicle [N m]: 1 to 4 % of its full torque."""
    deviation = vehicle.full_torque * random.uniform(0.01, 0.04)
    return np.asarray(deviation * wandering(count, random.uniform(0.3, 5.0), random))


def _check(case: Case) -> None:
    named = [("vehicle", case.vehicle, tuple(VEHICLES)), ("command", case.command, COMMANDS)]
    for what, name, known in [*named, *(("channel", channel, tuple(CHANNELS)) for channel in case.channels)]:
        if name not in known:
            raise ValueError(f"there is no {what} {name}; take one of {', '.join(known)}")
    for effect in case.effects:
        kind, colon, channel = effect.partition(":")
        if not colon and kind not in EFFECTS:
            raise ValueError(f"there is no effect {effect}; take one of {', '.join(EFFECTS)}")
        if colon and channel not in BY_CHANNEL.get(kind, ()):
            takes = "; ".join(f"{each} takes {', '.join(channels)}" for each, channels in BY_CHANNEL.items())
            raise ValueError(f"{effect} is no effect; {takes}")
        if colon and channel not in case.channels:
            raise ValueError(f"{effect} needs its channel; add {channel!r} to the case's channels")
