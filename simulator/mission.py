"""A mission, and all that is drawn for it before it is played."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import ModuleType

import numpy as np
from scipy.signal import lfilter

from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from service.recordings.recording import Recording
from simulator import effects, second_effects, sensors
from simulator.hull import Hulls
from simulator.physics import STEP, Physics, Setting, Truth, Yaw
from simulator.plans import OPEN_LOOP, Plan, pilot, plan
from simulator.sensors import Samples, Sensor
from simulator.vehicles import NAMES, YAW, Vehicle

TICK = 10
"""Steps of a tick, in which controllers and sensors are looked at once."""
TICK_S = TICK * STEP
BLOCK = 50
"""Ticks of a block: what follows from time alone is computed for a second at once."""
LISTS: Mapping[str, ModuleType] = {"main": effects, "second": second_effects}
"""The lists of effects, which were written apart; each has one function for each of these, with names and parameters of
the recording contract."""
EFFECTS = (
    "bias_torque", "inertia", "torque_lag", "torque_delay", "dead_zone", "torque_asymmetry", "torque_saturation",
    "inflow", "heading_current", "tether", "wave", "drag_drift", "drag_step", "memory", "coulomb", "bias_drift",
)  # fmt: skip
ON_CHANNEL = ("coupling", "modulation")
"""Effects that follow a further channel; the channel's name stands behind a colon."""
WATER = (0.1 / 18.0, 0.5 / 18.0)
"""The water's push: its deviation in largest efforts, from calm to rough."""
WATER_TIME = (0.5, 4.0)
"""Correlation time of the water's push [s]."""
TURNED = {"carried": (0.02, 0.08), "station": (0.006, 0.014)}
"""Rates at which the water turns a vehicle that it carries, or that holds its station [rad/s]."""
Sensing = Callable[[Vehicle, np.random.Generator], Sequence[Sensor]]


@dataclass(frozen=True, slots=True)
class Mission:
    """What is played.

    Attributes:
        vehicle: which moves.
        kind: what it does: of PLANS or OPEN_LOOP.
        seed: everything that is not said here follows from it.
        hidden: names of effects, by the recording contract's vocabulary.
        of: the list of effects that they are of.
        size: 1 for effects of realistic size.
        onset: when they come on [s], to the second.
        besides: what is hidden besides.
        duration: [s].
        beats: of the controller [Hz]; 50 or a whole part of it.
        sensing: makes the sensors; None for gyro and compass at the beats. Efforts that no sensor measures are logged
            as they were commanded.
        channels: further channels that are logged.
        water: 1 for water as it usually is, 0 for still water.
        current: velocity of the water to north and east [m/s].
        asked: what is asked for in place of the plan of `kind`.
    """

    vehicle: Vehicle
    kind: str
    seed: int
    hidden: tuple[str, ...] = ()
    of: str = "main"
    size: float = 1.0
    onset: float = 0.0
    besides: Physics = field(default_factory=Physics)
    duration: float = 720.0
    beats: float = 10.0
    sensing: Sensing | None = None
    channels: tuple[str, ...] = ()
    water: float = 1.0
    current: tuple[float, float] = (0.0, 0.0)
    asked: Plan | None = None

    def chance(self, what: str) -> np.random.Generator:
        """The stream of one kind of chance."""
        return np.random.default_rng([self.seed, zlib.crc32(f"{self.kind} {what}".encode())])


class Ship:
    """A mission with what is drawn for it, and what is in force of it.

    Attributes:
        every, ticks: ticks of a beat, and of the mission.
        heading: at the start [rad].
        hidden, truth: what comes on, and with which parameters.
        pilot: the controller.
        water_rms: deviation of the water's push (6,).
        yaw: what acts about yaw besides products of velocities; None for nothing.
    """

    def __init__(self, mission: Mission) -> None:
        vehicle, chance = mission.vehicle, mission.chance
        self.mission, self.physics = mission, mission.besides
        self.yaw: Yaw | None = None
        self.every = every = max(1, round(1.0 / (mission.beats * TICK_S)))
        if not math.isclose(every * TICK_S * mission.beats, 1.0):
            raise ValueError(f"a beat of {mission.beats} Hz is no whole number of ticks of {TICK_S} s")
        self.ticks = every * math.ceil(mission.duration / (every * TICK_S) - 1e-9)
        beats: Array = every * TICK_S * np.arange(self.ticks // every, dtype=np.float64)
        asked = mission.asked or plan(mission.kind, vehicle, beats, chance("plan"))
        self.pilot = pilot(asked, vehicle, every * TICK_S)
        self._courses = {
            name: sensors.channel(name, mission.duration, vehicle.time, chance(f"channel {name}"))
            for name in mission.channels
        }
        self.heading = float(chance("heading").uniform(-np.pi, np.pi)) if mission.kind in OPEN_LOOP else 0.0
        self.hidden, self.truth = _hide(mission, self._courses, self.heading)
        sensing = mission.sensing or (lambda vehicle, _: sensors.at_beats(vehicle, mission.beats))
        self._sensed = [
            (each, sensors.schedule(each, self.ticks * TICK_S, chance(f"log {each.quantity}")))
            for each in sensing(vehicle, chance("sensors"))
        ]
        self.water_rms, self._kept = _water(mission)
        self._water, self._push = chance("water"), self.water_rms * chance("first push").standard_normal(6)

    @property
    def changes(self) -> tuple[int, int]:
        """The ticks at which other equations come into force: the first, and the onset's."""
        return 0, BLOCK * round(self.mission.onset / (BLOCK * TICK_S))

    def change(self, tick: int, place: int, hulls: Hulls, asked: float) -> None:
        """Puts in force what is hidden from this tick on."""
        vehicle = self.mission.vehicle
        self.physics = self.mission.besides + (self.hidden if tick == self.changes[1] else Physics())
        if self.physics.inertia:
            mass = vehicle.mass.copy()
            mass[YAW, YAW] *= math.prod(self.physics.inertia)
            hulls.change(place, replace(vehicle, mass=mass))
        if Yaw.needed(vehicle, self.physics):
            self.yaw = Yaw(vehicle, self.physics, asked, float(hulls.state[place, YAW]))

    def block(self, time: Array) -> Array:
        """(n, 6) what pushes besides the efforts at the steps to come [s]."""
        kicks = self._water.standard_normal((time.size, 6)) * self.water_rms * math.sqrt(1.0 - self._kept**2)
        found, _ = lfilter([1.0], [1.0, -self._kept], kicks, axis=0, zi=self._kept * self._push[None])
        self._push = found[-1].copy()
        for course in self.physics.outside:
            found[:, YAW] += course(time)
        if self.yaw is not None:
            self.yaw.block(time)
        return np.asarray(found)

    def samples(self) -> dict[str, Samples]:
        """By quantity."""
        return {sensor.quantity: samples for sensor, samples in self._sensed}

    def recording(self, values: Mapping[str, Array], efforts: Array) -> Recording:
        """What is logged, from sampled values and the efforts (beats, 6) that were commanded."""
        streams = {
            sensor.quantity: (samples.stamps, sensors.seen(sensor, values[sensor.quantity]))
            for sensor, samples in self._sensed
        }
        beats = np.round(self.every * TICK_S * np.arange(efforts.shape[0]), 6)
        for name in self.mission.vehicle.effort:
            streams.setdefault(AXES[name].effort, (beats, efforts[:, NAMES.index(name)]))
        for name, course in self._courses.items():
            streams[name] = sensors.logged(name, course, self.ticks * TICK_S, self.mission.chance(f"log {name}"))
        return Recording(f"{self.mission.kind}_{self.mission.seed}", streams)


def _hide(
    mission: Mission, courses: Mapping[str, tuple[Array, Array]], heading: float
) -> tuple[Physics, dict[str, Truth]]:
    """What comes on, and its parameters; of size zero it is nothing."""
    vehicle, physics, truth = mission.vehicle, Physics(), dict[str, Truth]()
    turn = vehicle.rate * vehicle.time
    # In open loop a heading goes like a random walk; a controller keeps it within about R T.
    swing = 0.3 * turn * math.sqrt(2.0 * mission.duration / (3.0 * vehicle.time)) if mission.kind in OPEN_LOOP else turn
    for name in mission.hidden if mission.size else ():
        kind, colon, channel = name.partition(":")
        here = Setting(
            vehicle.inertia, vehicle.torque, vehicle.rate, mission.size, mission.chance(f"effect {name}"),
            mission.duration, heading, swing, *((channel, courses[channel]) if colon else ()),
        )  # fmt: skip
        found, truth[name] = vars(LISTS[mission.of])[kind](here)
        physics = physics + found
    return physics, truth


def _water(mission: Mission) -> tuple[Array, float]:
    """Deviation (6,) of the water's push, and the part of it that a step keeps."""
    vehicle, random = mission.vehicle, mission.chance("water's size")
    time = math.exp(random.uniform(*np.log(WATER_TIME)))
    share = random.uniform(*WATER)
    largest = 0.3 * max(vehicle.effort.values())
    rms = share * np.array([vehicle.effort.get(name, largest) for name in NAMES])
    if mission.kind in TURNED:
        # The rate of an Ornstein-Uhlenbeck moment through I ṙ + d' r, solved for the moment.
        drag = max(vehicle.linear_drag, 0.1 * vehicle.torque / vehicle.rate)
        rms[YAW] = random.uniform(*TURNED[mission.kind]) * drag * math.sqrt(1.0 + vehicle.inertia / (drag * time))
    return mission.water * rms, math.exp(-STEP / time)
