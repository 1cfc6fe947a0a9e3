"""Trials for the tracer: a recording, and beside it the truth that nobody told the tracer.

The vehicles are built to be unlike whatever a tracer may assume: drag that is no polynomial, noise in the water as well
as in the sensors, streams on their own clocks, coarse torque, outliers, channels that mean nothing. Everything follows
from the seed, and every kind of chance has a stream of its own: a trial with an effect of size zero is, to the byte,
the trial without it.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from service.recordings.recording import Recording, Streams, from_streams
from simulator.trial_channels import CHANNELS, channel, frequency, sensor_noise
from simulator.trial_command import command
from simulator.trial_effects import Circumstances, Physics, Scale, Truth, named
from simulator.trial_effects.physics import Array
from simulator.trial_sensors import PERIOD, Noise, Recorder
from simulator.trial_vehicle import DRAGS, SCALES, STEP, Gyro, Motion, drag, move

NOISE = 0.035
"""Deviation of the residual's noise in full torques: 3.5 N m at the paper's scale."""


TorqueNoise = Literal["commanded", "measured", "torque"]

HOLDS = (1, 2, 4)
"""Integration steps for which a command stands: 40, 20 or 10 Hz."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What is tried.

    Attributes:
        seed: everything that is not said here follows from it.
        effects: names of what is hidden, by the recording contract's vocabulary.
        size: 1 for effects of realistic size.
        vehicle: "leng" or "small".
        excitation: one of simulator.trial_command.EXCITATIONS.
        autocorrelation: of the residual's noise over 0.05 s.
        duration: [s].
        noise: what the torque is, and where the noise of the residual is. "commanded": the commands as they were given,
            all noise in the water; "measured": what lasts is in the water, and the torque's sensor is white; "torque":
            all of it in the torque's sensor, as in textbooks and on no vehicle.
    """

    seed: int
    effects: tuple[str, ...] = ()
    size: float = 1.0
    vehicle: str = "leng"
    excitation: str = "telegraph"
    autocorrelation: float = 0.0
    duration: float = 720.0
    noise: TorqueNoise = "measured"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a trial. Attributes:

    trial: what was tried.
    inertia: what the operator declares [kg m²].
    recording: what the recorder kept; NaN where a column was not sampled.
    truth: the hidden effects' parameters by name.
    lacking: (n,) the moment at every step that τ − I ṙ − d(r) lacks because of what is hidden [N m].
    evidence: twice the log-likelihood ratio that a reader who knew the effect's shape, its parameters and the noise
        could expect; nobody can find an effect whose evidence is of the order of one.
    motion: what truly happened.
    """

    trial: Trial
    inertia: float
    recording: Recording
    truth: dict[str, Truth]
    lacking: Array
    evidence: float
    motion: Motion


def play(trial: Trial) -> Outcome:
    """Plays a trial. Raises KeyError for a name that does not exist."""
    draws = [np.random.default_rng(seed) for seed in np.random.SeedSequence(trial.seed).spawn(5)]
    for_vehicle, for_command, for_water, for_channels, for_sensors = draws
    scale = SCALES[trial.vehicle]
    scale = replace(scale, inertia=scale.inertia * for_vehicle.uniform(0.9, 1.2))
    steps = round(trial.duration / STEP)
    ticks = np.arange(2 * steps + 1) * STEP / 2

    total = NOISE * scale.torque
    noise = Noise.drawn(total, trial.autocorrelation, for_water)
    if trial.noise == "torque":
        noise = Noise.in_the_torque(total, trial.autocorrelation)
    elif trial.noise == "commanded":
        noise = Noise.in_the_water(total, trial.autocorrelation)
    hold = round(PERIOD / STEP)
    water = np.repeat(noise.water(-(-steps // hold), for_water), hold)[:steps]
    channels = _channels(trial, ticks, scale, for_channels)

    plain = Physics(scale.inertia, drag(str(for_vehicle.choice(sorted(DRAGS))), scale))
    physics, truth = plain, {}
    for name in trial.effects:
        # A generator of its own for each name: an effect is the same alone and beside another.
        own = np.random.default_rng([trial.seed, zlib.crc32(name.encode())])
        physics, truth[name] = named(name)(physics, Circumstances(scale, trial.size, own, ticks, channels))
    heading = float(for_vehicle.uniform(-np.pi, np.pi)) if "tether" not in trial.effects else 0.0
    asked = command(trial.excitation, scale, ticks, for_command, int(for_command.choice(HOLDS)))
    recorder = Recorder.drawn(scale, noise, for_sensors)
    if trial.noise == "commanded":
        asked = replace(asked, step=recorder.torque_step)
    gyro = recorder.gyro(trial.duration - STEP, for_sensors)
    motion = move(physics, asked, water, heading, gyro=gyro)

    damping = np.array([plain.drag(rate) for rate in motion.yaw_rate.tolist()])
    lacking = scale.inertia * motion.acceleration - (motion.command - damping + water)
    streams = _record(trial, motion, gyro, asked.hold, channels, recorder, noise, for_sensors)
    return Outcome(
        trial=trial,
        inertia=scale.inertia,
        recording=from_streams(f"trial_{trial.seed}", streams),
        truth=truth,
        lacking=lacking,
        evidence=_evidence(lacking, motion.yaw_rate, noise, recorder, scale),
        motion=motion,
    )


def _channels(trial: Trial, ticks: Array, scale: Scale, random: np.random.Generator) -> dict[str, Array]:
    """What the effects need, and up to three channels that mean nothing."""
    needed = [name.partition(":")[2] for name in trial.effects if ":" in name]
    idle = random.permutation(CHANNELS)[: int(random.integers(0, 4))].tolist()
    draws = dict(zip(CHANNELS, random.spawn(len(CHANNELS)), strict=True))
    return {name: channel(name, ticks, scale.time, draws[name]) for name in dict.fromkeys([*needed, *idle])}


def _record(
    trial: Trial,
    motion: Motion,
    gyro: Gyro,
    hold: int,
    channels: dict[str, Array],
    recorder: Recorder,
    noise: Noise,
    random: np.random.Generator,
) -> Streams:
    """The streams as the recorder gets them; a generator for each, so that none depends on which others there are."""
    names = ("torque", "heading", *CHANNELS)
    draws = dict(zip(names, random.spawn(len(names)), strict=True))
    end = trial.duration
    ticks = np.arange(2 * motion.time.size + 1) * STEP / 2

    def sampled(name: str, often: float, source: Array, clock: Array) -> tuple[Array, Array, np.random.Generator]:
        time = recorder.stamps(end - STEP, often, draws[name])
        return time, np.interp(time, clock, source), draws[name]

    streams: Streams = {"yaw_rate": (gyro.time, gyro.seen(motion))}
    if trial.noise == "commanded":
        streams["torque"] = recorder.commanded_torque(motion, hold, draws["torque"])
    else:
        time, values, draw = sampled("torque", float(random.choice([10.0, 20.0, 25.0])), motion.command, motion.time)
        streams["torque"] = (time, recorder.measured_torque(time, values, noise.total, draw))
    if random.random() < 0.8:
        time, values, draw = sampled("heading", 10.0, motion.heading, motion.time)
        streams["heading"] = (time, recorder.heading(values, draw))
    needed = {name.partition(":")[2] for name in trial.effects}
    for name, course in channels.items():
        time, values, draw = sampled(name, frequency(name), course, ticks)
        deviation = float(np.std(course))
        if name not in needed and draw.random() < 0.25:
            # A channel that follows the turning without acting on it: a sensor off the centre, a hull that leans.
            rate = motion.yaw_rate / np.std(motion.yaw_rate)
            values = values + 0.7 * deviation * np.interp(time, motion.time, rate)
        streams[name] = (time, values + sensor_noise(name) * deviation * draw.standard_normal(time.size))
    return streams


def _evidence(lacking: Array, rate: Array, noise: Noise, recorder: Recorder, scale: Scale) -> float:
    """Σ |L(f)|²/S(f): L the lacking moment without what a curve d(r), d(0) = 0, takes over, S the noise's spectrum."""
    hold = round(PERIOD / STEP)
    count = lacking.size // hold
    moment = lacking[: count * hold].reshape(count, hold).mean(axis=1)
    rates = rate[: count * hold : hold]
    knots = np.linspace(rates.min(), rates.max(), 12)
    # Hat functions of the rate; each loses its value at zero, so that all curves pass through the origin.
    hats = np.column_stack([np.interp(rates, knots, row) - np.interp(0.0, knots, row) for row in np.eye(knots.size)])
    left = moment - hats @ np.linalg.lstsq(hats, moment, rcond=None)[0]
    angle = np.pi * np.fft.rfftfreq(count) * 2

    def colour(memory: float) -> Array:
        return np.asarray((1 - memory**2) / np.abs(1 - memory * np.exp(-1j * angle)) ** 2)

    gyro = (scale.inertia * recorder.gyro_noise / PERIOD) ** 2 * np.abs(1 - np.exp(-1j * angle)) ** 2
    water = noise.water_share * colour(noise.water_memory)
    spectrum = noise.total**2 * (water + (1 - noise.water_share) * colour(noise.sensor_memory)) + gyro
    power = np.abs(np.fft.rfft(left)) ** 2 / spectrum
    return float((2 * power.sum() - power[0]) / count)
