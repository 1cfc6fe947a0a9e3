"""The simulated worlds (trials, missions, second cases) by one measure: chance, effects of no size, what acts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from incsvr.numerics import Array
from service.recordings.recording import Recording
from simulator import missions, second, trial
from simulator.missions import FULL_SIZE, KINDS, Mission
from simulator.second import COMMANDS, Case
from simulator.second.play import chance, water
from simulator.trial import Trial
from simulator.trial_channels import CHANNELS, channel
from simulator.trial_command import EXCITATIONS, Command
from simulator.trial_effects import EFFECTS, Circumstances, Physics, named
from simulator.trial_vehicle import SCALES, STEP, move
from tests.simulator.textbook import Ride, moment

LENG = SCALES["leng"]
SLOPE = LENG.torque / LENG.rate
"""Slope of a linear drag [N m s/rad]: with it both forms of water that turns along are one."""
BY_CHANNEL = ("coupling:sway", "modulation:voltage")
OF_TRIALS = (*EFFECTS, *BY_CHANNEL, "coupling:winch_load", "modulation:depth")
OF_SECOND = (*second.EFFECTS, *BY_CHANNEL, "modulation:depth")
USUAL = Case(seed=4, vehicle="work_rov", command="noise_band", channels=("sway", "voltage", "depth"), duration=240.0)


@dataclass(frozen=True)
class World:
    """A simulated world: a short run of a seed, without an effect or with one of a size."""

    play: Callable[..., Recording]
    effects: tuple[str, ...]


def of_trials(
    seed: int, effect: str = "", size: float = 1.0, vehicle: str = "leng", kind: str = "telegraph"
) -> Recording:
    hidden = (effect,) if effect else ()
    return trial.play(Trial(seed, hidden, size, vehicle, kind, duration=20.0)).recording


def of_missions(
    seed: int, effect: str = "", size: float = 1.0, vehicle: str = "auv", kind: str = "bursts"
) -> Recording:
    return missions.play(Mission(kind, vehicle, seed, effect or None, size, duration=60.0)).recording


def of_second(
    seed: int, effect: str = "", size: float = 1.0, vehicle: str = "work_rov", kind: str = "heading_pd",
    torque: str = "measured",
) -> Recording:  # fmt: skip
    hidden = (effect,) if effect else ()
    case = Case(seed, vehicle, kind, torque, hidden, size, USUAL.channels, duration=30.0)  # type: ignore[arg-type]
    return second.play(case).recording


WORLDS = {
    "trials": World(of_trials, OF_TRIALS),
    "missions": World(of_missions, tuple(FULL_SIZE)),
    "second": World(of_second, OF_SECOND),
}
HIDDEN = [(world, effect) for world, each in WORLDS.items() for effect in each.effects]
RUNS: list[tuple[str, dict[str, str]]] = [
    *(("trials", {"vehicle": vehicle, "kind": kind}) for vehicle in SCALES for kind in EXCITATIONS),
    *(("missions", {"vehicle": vehicle, "kind": kind}) for vehicle in missions.VEHICLES for kind in KINDS),
    *(("second", {"kind": kind, "torque": torque}) for kind in COMMANDS for torque in ("commanded", "measured")),
    *(("second", {"vehicle": vehicle}) for vehicle in second.VEHICLES),
]


def columns(recording: Recording, names: tuple[str, ...] = ()) -> dict[str, bytes]:
    """The streams to the byte, all or those that are named."""
    streams = recording.streams()
    return {name: b"".join(part.tobytes() for part in streams[name]) for name in names or streams}


@pytest.mark.parametrize(
    ("world", "settings"), RUNS, ids=lambda value: "-".join(value.values()) if isinstance(value, dict) else value
)
def test_a_seed_is_a_recording(world: str, settings: dict[str, str]) -> None:
    play = WORLDS[world].play
    first = columns(play(1, **settings))
    assert first == columns(play(1, **settings))
    assert first.get("yaw_rate") != columns(play(2, **settings)).get("yaw_rate")


@pytest.mark.parametrize(("world", "effect"), HIDDEN)
def test_an_effect_of_no_size_is_none_and_of_its_size_is_one(world: str, effect: str) -> None:
    """A tether is straight where the heading is zero: in trials it begins there, and nothing else may differ."""
    play, seen = WORLDS[world].play, ("yaw_rate", "torque")
    for settings in [{"vehicle": vehicle} for vehicle in SCALES] if world == "trials" else [{}]:
        plain = columns(play(21, **settings), seen)
        assert columns(play(21, effect, 0.0, **settings), seen) == plain
        assert columns(play(21, effect, **settings), seen) != plain


def of_trial(name: str, seed: int) -> tuple[Array, Array]:
    """The textbook's moment and what is lacking, of a vehicle that a multisine drives in still water."""
    steps = round(150.0 / STEP)
    ticks = STEP / 2 * np.arange(2 * steps + 1, dtype=np.float64)
    channels = {each: channel(each, ticks, LENG.time, np.random.default_rng(5)) for each in CHANNELS}
    here = Circumstances(LENG, 1.0, np.random.default_rng(seed), ticks, channels)
    physics, told = named(name)(Physics(LENG.inertia, lambda rate: SLOPE * rate), here)
    command = 60.0 * np.sin(2 * np.pi * ticks / 31.0) + 35.0 * np.sin(2 * np.pi * ticks / 11.0 + 1.0)
    motion = move(physics, Command(command.tolist()), np.zeros(steps), 0.0)
    follows = channels[name.partition(":")[2]][:-1:2] if ":" in name else np.empty(0)
    ride = Ride(STEP, motion.command, motion.yaw_rate, motion.heading, motion.acceleration, SLOPE * motion.yaw_rate,
                LENG.inertia, follows, creep=0.02 * LENG.rate)  # fmt: skip
    return moment(name, told, ride), ride.lacking()


def of_mission(name: str, seed: int) -> tuple[Array, Array]:
    """The same of a mission in still water, but for where the command jumps: the slope is of neither side there."""
    outcome = missions.play(Mission("bursts", "auv", seed, name, water=0.0, duration=300.0))
    motion = outcome.motion
    torque = np.repeat(motion.command, motion.time.size // motion.command.size)
    rate = motion.yaw_rate
    ride = Ride(STEP, torque, rate, motion.heading, np.gradient(rate, STEP), outcome.damping(rate), outcome.inertia,
                np.empty(0))  # fmt: skip
    steady = np.ones(rate.size, dtype=bool)
    for shift in (0.0, float(outcome.truth.get("delay_s", 0.0))):
        for jump in np.flatnonzero(np.diff(torque)) + round(shift / STEP):
            steady[max(jump - 2, 0) : jump + 4] = False
    return moment(name, outcome.truth, ride)[steady], ride.lacking()[steady]


def of_second_case(name: str, seed: int, size: float = 1.0, duration: float = 480.0) -> tuple[Array, Array]:
    """The same of a second case, whose water is drawn again and counts as known."""
    hidden = replace(USUAL, seed=seed, effects=(name,), size=size, duration=duration)
    played, vehicle = second.play(hidden), second.VEHICLES[hidden.vehicle]
    motion, step = played.motion, second.plant.STEP
    rate = motion.yaw_rate
    before = np.concatenate([[0.0], rate[:-1]])
    drag = vehicle.drag()
    declared = np.array([drag(each) for each in (0.5 * (before + rate)).tolist()])
    torque = np.repeat(motion.command, rate.size // motion.command.size)
    stamps, values = played.recording.streams()[name.partition(":")[2]] if ":" in name else (np.zeros(1), np.zeros(1))
    time = step * np.arange(rate.size, dtype=np.float64)
    ride = Ride(step, torque, rate, motion.heading, (rate - before) / step, declared, vehicle.inertia,
                np.interp(time, stamps, values))  # fmt: skip
    outside = water(vehicle, rate.size, chance(hidden, "water"))
    return moment(name, played.truth[name], ride), ride.lacking(outside)


@cache
def usual_command() -> Array:
    return second.play(USUAL).motion.command


STEEP = 0.2
"""A wave has crests, a second harmonic that no textbook tells."""


@pytest.mark.parametrize("seed", [11, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (12, 13))])
@pytest.mark.parametrize("name", OF_TRIALS)
def test_what_a_trial_tells_of_an_effect_is_what_acts(name: str, seed: int) -> None:
    expected, acts = of_trial(name, seed)
    size = np.sqrt(np.mean(expected**2))
    assert size > 1.0
    assert np.sqrt(np.mean((acts - expected) ** 2)) < (STEEP if name == "wave" else 0.03) * size
    assert expected @ acts == pytest.approx(expected @ expected, rel=0.01)


@pytest.mark.parametrize("name", sorted(FULL_SIZE))
def test_what_a_mission_tells_of_an_effect_is_what_acts(name: str) -> None:
    expected, acts = of_mission(name, 5)
    size = np.sqrt(np.mean(expected**2))
    assert size > 0.1
    assert np.sqrt(np.mean((acts - expected) ** 2)) < 0.03 * size + 0.01


@pytest.mark.parametrize("seed", [4, pytest.param(5, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", OF_SECOND)
def test_a_second_case_acts_like_the_textbook_with_what_it_tells(name: str, seed: int) -> None:
    """Its effects have other shapes: similar in sign and size is all that is asked."""
    textbook, acts = of_second_case(name, seed)
    assert 0.7 < textbook @ acts / (textbook @ textbook) < 1.4
    assert textbook @ acts > 0.8 * np.linalg.norm(textbook) * np.linalg.norm(acts)


@pytest.mark.slow
@pytest.mark.parametrize("name", [each for each in OF_SECOND if each != "modulation:depth"])
def test_an_effect_of_a_second_case_is_of_realistic_size_and_half_of_it_is_less(name: str) -> None:
    command = usual_command()
    half, whole = (of_second_case(name, USUAL.seed, size, USUAL.duration)[1] for size in (0.5, 1.0))
    shares = [float(np.sqrt(np.mean(acts**2) / np.mean(command**2))) for acts in (half, whole)]
    assert 0.04 < shares[1] < 0.6
    assert 0.3 < shares[0] / shares[1] < 0.8


@pytest.mark.parametrize("name", OF_TRIALS)
def test_an_effect_of_a_trial_can_be_seen_by_who_knows_its_shape_and_half_of_it_less(name: str) -> None:
    whole = trial.play(Trial(seed=8, effects=(name,), excitation="multisine", duration=150.0))
    half = trial.play(Trial(seed=8, effects=(name,), size=0.5, excitation="multisine", duration=150.0))
    assert whole.evidence > half.evidence > 10.0
    assert set(whole.truth) == {name}
