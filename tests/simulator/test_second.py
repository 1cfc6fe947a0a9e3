"""The second simulator: its physics, its sensors and its chances, and that it is a second one."""

from __future__ import annotations

import ast
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracer.second_cases import KINDS, case
from service.recordings.recording import Recording
from service.recordings.recording_csv import read, write
from simulator.second import (
    BY_CHANNEL,
    CLOSED_LOOP,
    EFFECTS,
    OPEN_LOOP,
    VEHICLES,
    Case,
    commands,
    play,
)
from simulator.second.commands import computer_period, pilot_of
from simulator.second.hidden import hide
from simulator.second.motion import Motion, motion_of
from simulator.second.plant import STEP, Array, Plant, Setting
from simulator.second.play import chance
from simulator.second.sensors import clocked

ROOT = Path(__file__).resolve().parent.parent.parent
CHANNELS = ("sway", "voltage")
NAMES = (*EFFECTS, "coupling:sway", "modulation:voltage")
USUAL = Case(seed=4, vehicle="work_rov", command="noise_band", channels=CHANNELS, duration=240.0)


def same(one: Recording, other: Recording) -> bool:
    """To the byte."""
    return one.time.tobytes() == other.time.tobytes() and {
        name: values.tobytes() for name, values in one.columns.items()
    } == {name: values.tobytes() for name, values in other.columns.items()}


def held(motion: Motion) -> Array:
    """(n,) the command in force in each step [N m]."""
    return np.repeat(motion.command, motion.yaw_rate.size // motion.command.size)


def coasting(vehicle: str, effects: tuple[str, ...] = ()) -> tuple[Plant, Motion]:
    """A vehicle that turned at its full rate when its thrusters stopped, in still water."""
    that = VEHICLES[vehicle]
    time = STEP * np.arange(int(6 * that.time_scale / STEP), dtype=np.float64)
    plant = Plant(that.inertia, that.drag(), np.ones(time.size), np.ones(time.size), np.zeros(time.size))
    for name in effects:
        random = np.random.default_rng(1)
        turn = that.full_rate * that.time_scale
        setting = Setting(that.full_torque, that.full_rate, that.time_scale, 0.0, turn, 1.0, random, time, {})
        plant, _ = hide(plant, name, setting)
    gyro = clocked(6 * that.time_scale, (20.0, 50.0), (0.0, 0.0), np.random.default_rng(1))
    return plant, motion_of(plant, lambda _tick, _rate, _heading: 0.0, 10, gyro, None, (that.full_rate, 0.0))


@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
def test_the_drag_takes_the_energy_that_the_vehicle_loses(vehicle: str) -> None:
    plant, motion = coasting(vehicle)
    rates = np.concatenate([[VEHICLES[vehicle].full_rate], motion.yaw_rate])
    energy = 0.5 * plant.inertia * rates**2
    assert (np.diff(energy) < 0.0).all()
    assert rates[-1] < 0.3 * rates[0]
    power = np.array([plant.drag(r) * r for r in rates.tolist()])
    taken = STEP * np.sum(0.5 * (power[1:] + power[:-1]))
    assert taken == pytest.approx(energy[0] - energy[-1], rel=1e-3)


@pytest.mark.parametrize("name", ["memory", "coulomb", "drag_step", "drag_drift"])
def test_an_effect_of_the_water_gives_no_energy(name: str) -> None:
    for vehicle in VEHICLES:
        _, motion = coasting(vehicle, (name,))
        assert (np.diff(np.abs(motion.yaw_rate)) <= 0.0).all(), vehicle


@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
def test_full_torque_holds_about_the_full_rate(vehicle: str) -> None:
    that = VEHICLES[vehicle]
    for sign in (1.0, -1.0):
        x = np.linspace(0.0, 1.3, 400) * sign
        drag = np.array([that.drag()(r) for r in (x * that.full_rate).tolist()]) * sign
        assert drag[0] == 0.0
        assert (np.diff(drag) > 0.0).all()
        assert 0.8 < np.interp(1.0, np.abs(x), drag) / that.full_torque < 1.05


@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
def test_a_closed_loop_follows_its_reference(vehicle: str) -> None:
    for command, heard in (("rate_pi", "yaw_rate"), ("heading_pd", "heading")):
        that = Case(seed=11, vehicle=vehicle, command=command, duration=40 * VEHICLES[vehicle].time_scale)
        motion = play(that).motion
        wanted = reference_of(that, motion)
        true = motion.yaw_rate if heard == "yaw_rate" else motion.heading
        error = true[:: true.size // wanted.size][: wanted.size] - wanted
        assert np.std(error) < 0.75 * np.std(wanted), command
        assert np.median(np.abs(error)) < 0.35 * np.std(wanted), command


def reference_of(that: Case, motion: Motion) -> Array:
    """(ticks,) what the controller was to hold, drawn again in the order in which the pilot drew it."""
    vehicle, random = VEHICLES[that.vehicle], chance(that, "command")
    random.choice(commands.THRUSTER_STEPS)
    period = motion.yaw_rate.size * STEP / motion.command.size
    time = period * np.arange(motion.command.size, dtype=np.float64)
    if that.command == "rate_pi":
        return commands.rate_reference(time, vehicle, random)
    return commands.heading_reference(time, vehicle, random, float(chance(that, "start").uniform(-np.pi, np.pi)))


@pytest.mark.parametrize("command", CLOSED_LOOP)
def test_a_controller_sees_what_is_logged_and_nothing_else(command: str) -> None:
    that = Case(seed=8, vehicle="torpedo", command=command, effects=("torque_lag",), duration=120.0)
    streams = play(that).recording.streams()
    vehicle, stamps = VEHICLES[that.vehicle], streams["torque"][0]
    start = float(chance(that, "start").uniform(-np.pi, np.pi))
    pilot = pilot_of(command, vehicle, stamps, start, chance(that, "command"))
    seen = []
    for name, first in (("yaw_rate", 0.0), ("heading", start)):
        when, values = streams[name]
        seen.append(np.concatenate([[first], values])[np.searchsorted(when, stamps, side="right")])
    asked = [pilot(tick, float(seen[0][tick]), float(seen[1][tick])) for tick in range(stamps.size)]
    np.testing.assert_array_equal(asked, streams["torque"][1])
    assert np.allclose(np.diff(stamps), computer_period(vehicle, chance(that, "computer")))


@pytest.mark.parametrize("command", sorted(OPEN_LOOP))
def test_a_command_is_held_and_logged_as_given(command: str) -> None:
    played = play(replace(USUAL, command=command))
    np.testing.assert_array_equal(played.motion.thrust, held(played.motion))
    np.testing.assert_array_equal(played.recording.streams()["torque"][1], played.motion.command)
    assert np.abs(played.motion.command).max() <= VEHICLES[USUAL.vehicle].full_torque


def test_a_measured_torque_is_the_command_with_noise_and_never_the_lagging_thrust() -> None:
    measured = replace(USUAL, torque="measured", duration=720.0)
    clean, lagging = play(measured), play(replace(measured, effects=("torque_lag",)))
    stamps, values = clean.recording.streams()["torque"]
    np.testing.assert_array_equal(values, lagging.recording.streams()["torque"][1])
    assert not np.array_equal(clean.motion.thrust, lagging.motion.thrust)
    full = VEHICLES[USUAL.vehicle].full_torque
    noise = (values - held(clean.motion)[(stamps / STEP).astype(int)]) / full
    usual = np.abs(noise) < 0.2
    assert 0.009 < np.std(noise[usual]) < 0.041
    assert abs(np.corrcoef(noise[usual][1:], noise[usual][:-1])[0, 1]) < 0.05
    assert 0.0 < np.mean(~usual) < 0.004
    assert 9.0 < 1.0 / np.diff(stamps).mean() < 51.0


def test_streams_have_clocks_of_their_own_and_a_recording_can_be_written(tmp_path: Path) -> None:
    recording = play(replace(USUAL, torque="measured", duration=60.0)).recording
    streams = recording.streams()
    assert set(streams) == {"yaw_rate", "torque", "heading", *CHANNELS}
    for one, other in itertools.combinations(streams, 2):
        assert not np.intersect1d(streams[one][0], streams[other][0]).size
    write(tmp_path / "run.csv", recording)
    again = read(tmp_path / "run.csv")
    assert all(np.array_equal(again.columns[name], recording.columns[name], equal_nan=True) for name in streams)


def test_no_cell_of_the_cases_stays_empty() -> None:
    def cells(count: int, *fields: str) -> int:
        kinds = [KINDS[k % len(KINDS)] for k in range(count)]
        cases = [case("one", k, 100) for k in range(count)]
        drawn = zip(kinds, cases, strict=True)
        return len({(kind, *(getattr(each, field) for field in fields)) for kind, each in drawn})

    assert cells(36, "torque") == 18 * 2
    assert cells(90, "vehicle") == 18 * 5
    assert cells(126, "command") == 18 * 7
    assert cells(1260, "command", "vehicle", "torque") == 18 * 7 * 5 * 2
    quiet = [case("quiet", k, 100) for k in range(70)]
    assert len({(each.command, each.vehicle, each.torque) for each in quiet}) == 70
    assert not any(each.effects for each in quiet)
    assert case("half", 3, 100) == replace(case("one", 3, 100), size=0.5)


def test_a_case_says_what_it_lacks() -> None:
    with pytest.raises(ValueError, match=r"no vehicle yacht; take one of micro_rov"):
        play(replace(USUAL, vehicle="yacht"))
    with pytest.raises(ValueError, match=r"add 'depth' to the case's channels"):
        play(replace(USUAL, effects=("modulation:depth",)))
    with pytest.raises(ValueError, match=r"no effect magic; take one of bias_torque"):
        play(replace(USUAL, effects=("magic",)))
    with pytest.raises(ValueError, match=r"modulation:sway is no effect; .* voltage"):
        play(replace(USUAL, effects=("modulation:sway",)))


def test_it_shares_nothing_with_the_first_simulator_or_the_tracer() -> None:
    files = [*(ROOT / "simulator" / "second").rglob("*.py"), ROOT / "benchmarks" / "tracer" / "second_cases.py"]
    assert len(files) > 5
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            modules += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for module in modules:
                ours = module.partition(".")[0] in {"incsvr", "service", "simulator", "viewer", "benchmarks"}
                shared = module == "service.recordings.recording" or (module + ".").startswith("simulator.second.")
                assert shared or not ours, f"{path.relative_to(ROOT)} imports {module}"


def test_what_scales_thrust_or_drag_is_never_zero() -> None:
    for name in BY_CHANNEL["modulation"]:
        values = play(replace(USUAL, channels=(name,))).recording.streams()[name][1]
        assert (values > 0.0).all()
        assert np.std(values) > 0.0
