"""The trial vehicle is a vehicle: its physics, its recorder, and what every hidden effect does to it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simulator.effects import EFFECTS, Circumstances, Physics, named
from simulator.effects.physics import Array
from simulator.trial import Trial, play
from simulator.trial_channels import CHANNELS, channel
from simulator.trial_command import EXCITATIONS, Command
from simulator.trial_vehicle import DRAGS, SCALES, STEP, Motion, drag, move

ALL = (*EFFECTS, "coupling:sway", "coupling:winch_load", "modulation:voltage", "modulation:depth")
LENG = SCALES["leng"]


def drive(physics: Physics, table: float | Array, seconds: float = 60.0) -> Motion:
    """The noiseless vehicle under a constant or tabled command."""
    steps = round(seconds / STEP)
    values = np.broadcast_to(table, 2 * steps + 1).tolist()
    return move(physics, Command(values), np.zeros(steps), 0.0)


def hide(name: str, size: float = 1.0, seconds: float = 60.0) -> tuple[Physics, dict[str, float | str]]:
    ticks = np.arange(2 * round(seconds / STEP) + 1) * STEP / 2
    plain = Physics(LENG.inertia, lambda rate: 300.0 * rate)
    channels = {each: channel(each, ticks, LENG.time, np.random.default_rng(5)) for each in CHANNELS}
    return named(name)(plain, Circumstances(LENG, size, np.random.default_rng(11), ticks, channels))


def number(truth: dict[str, float | str], name: str) -> float:
    value = truth[name]
    assert isinstance(value, float | int)
    return float(value)


@pytest.mark.parametrize("shape", sorted(DRAGS))
@pytest.mark.parametrize("vehicle", sorted(SCALES))
def test_drag_takes_energy_and_vanishes_at_rest(shape: str, vehicle: str) -> None:
    scale = SCALES[vehicle]
    curve = drag(shape, scale)
    rates = np.linspace(-1.2, 1.2, 241) * scale.rate
    moments = np.array([curve(rate) for rate in rates.tolist()])
    assert curve(0.0) == 0.0
    assert np.all(moments * rates >= 0.0)
    assert np.all(np.diff(moments) > 0.0)
    assert 0.6 * scale.torque < curve(scale.rate) < 1.1 * scale.torque


def test_no_drag_is_a_polynomial_of_the_rate_and_its_square() -> None:
    rates = np.linspace(-1.0, 1.0, 201)
    for curve in DRAGS.values():
        moments = np.array([curve(rate) for rate in rates.tolist()])
        terms = np.column_stack([rates, rates * np.abs(rates)])
        left = moments - terms @ np.linalg.lstsq(terms, moments, rcond=None)[0]
        assert np.std(left) > 0.004 * np.std(moments)


def test_without_drag_the_work_of_the_thrusters_is_the_energy_of_the_turning() -> None:
    random = np.random.default_rng(0)
    command = 30.0 * np.cumsum(random.standard_normal(2 * round(60 / STEP) + 1)) * 0.02
    motion = drive(Physics(LENG.inertia, lambda _rate: 0.0), command)
    work = np.sum(0.5 * (motion.command[1:] + motion.command[:-1]) * np.diff(motion.heading))
    energy = 0.5 * LENG.inertia * motion.yaw_rate[-1] ** 2
    assert work == pytest.approx(energy, rel=1e-3)


def test_the_integrator_follows_the_exact_solution_to_fourth_order() -> None:
    motion = drive(Physics(LENG.inertia, lambda rate: 300.0 * rate), 60.0)
    exact = 0.2 * -np.expm1(-300.0 / LENG.inertia * motion.time)
    np.testing.assert_allclose(motion.yaw_rate, exact, atol=1e-9)


@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_every_excitation_turns_the_vehicle_and_stays_within_the_thrusters(excitation: str) -> None:
    for vehicle, scale in SCALES.items():
        motion = play(Trial(seed=4, vehicle=vehicle, excitation=excitation, duration=150.0)).motion
        assert np.max(np.abs(motion.command)) <= scale.torque * (1 + 1e-12)
        assert np.std(motion.yaw_rate) > 0.2 * scale.rate
        assert np.max(np.abs(motion.yaw_rate)) < 1.5 * scale.rate


@pytest.mark.parametrize("name", ALL)
def test_an_effect_of_size_zero_changes_nothing(name: str) -> None:
    # A channel that the effect needs is recorded either way only if it is drawn; so compare what both recorded.
    for vehicle in SCALES:
        quiet = play(Trial(seed=21, vehicle=vehicle, duration=20.0))
        zero = play(Trial(seed=21, effects=(name,), size=0.0, vehicle=vehicle, duration=20.0))
        np.testing.assert_allclose(zero.lacking, 0.0, atol=1e-9 * LENG.torque)
        if "tether" not in name:  # a tether is straight where the heading is zero, so there it begins at zero
            np.testing.assert_allclose(zero.motion.heading, quiet.motion.heading, atol=1e-10)
        for column in ("yaw_rate", "torque"):
            kept = zero.recording.columns[column][~np.isnan(zero.recording.columns[column])]
            np.testing.assert_allclose(
                kept, quiet.recording.columns[column][~np.isnan(quiet.recording.columns[column])], atol=1e-9
            )


@pytest.mark.parametrize("name", ALL)
def test_an_effect_can_be_seen_by_who_knows_its_shape_and_half_of_it_less(name: str) -> None:
    whole = play(Trial(seed=8, effects=(name,), excitation="multisine", duration=150.0))
    half = play(Trial(seed=8, effects=(name,), size=0.5, excitation="multisine", duration=150.0))
    assert whole.evidence > half.evidence > 10.0
    assert set(whole.truth) == {name}


def test_with_nothing_hidden_nothing_is_lacking() -> None:
    quiet = play(Trial(seed=3, autocorrelation=0.9, duration=60.0))
    np.testing.assert_allclose(quiet.lacking, 0.0, atol=1e-9 * LENG.torque)
    assert quiet.evidence < 1e-9
    assert quiet.truth == {}


def test_a_seed_is_a_recording() -> None:
    trial = Trial(seed=12, effects=("wave", "coupling:sway"), excitation="closed_loop", duration=60.0)
    first, second, other = play(trial), play(trial), play(replace(trial, seed=13))
    assert first.truth == second.truth
    assert list(first.recording.columns) == list(second.recording.columns)
    for name, column in first.recording.columns.items():
        np.testing.assert_array_equal(column, second.recording.columns[name])
    assert first.truth != other.truth


def test_a_second_effect_leaves_the_first_as_it_was() -> None:
    alone = play(Trial(seed=5, effects=("coulomb",), duration=30.0))
    for names in (("coulomb", "wave"), ("wave", "coulomb")):
        both = play(Trial(seed=5, effects=names, duration=30.0))
        assert alone.truth["coulomb"] == both.truth["coulomb"]


# What each effect does, in the steady state or on the one signal that shows it alone. The drag is 300 N m s/rad · r.


def test_a_bias_turns_the_idle_vehicle() -> None:
    physics, truth = hide("bias_torque")
    assert drive(physics, 0.0).yaw_rate[-1] == pytest.approx(number(truth, "moment_nm") / 300.0, rel=1e-9)


def test_a_drifting_bias_begins_at_nothing() -> None:
    physics, truth = hide("bias_drift")
    motion = drive(physics, 0.0)
    assert motion.acceleration[0] == 0.0
    # Behind a ramp a first-order vehicle lags by I/d'.
    expected = number(truth, "nm_per_s") * (motion.time[-1] - LENG.inertia / 300.0) / 300.0
    assert motion.yaw_rate[-1] == pytest.approx(expected, rel=1e-6)


def test_another_inertia_changes_the_start_and_not_the_end() -> None:
    physics, truth = hide("inertia")
    motion = drive(physics, 60.0)
    assert motion.acceleration[0] == pytest.approx(60.0 / number(truth, "inertia_kg_m2"))
    assert motion.yaw_rate[-1] == pytest.approx(0.2, rel=1e-6)


def test_a_lag_and_a_delay_come_late_and_in_full() -> None:
    for name in ("torque_lag", "torque_delay"):
        physics, truth = hide(name)
        motion = drive(physics, 60.0)
        assert motion.yaw_rate[-1] == pytest.approx(0.2, rel=1e-6)
        command = np.where(np.arange(2 * round(60 / STEP) + 1) * STEP / 2 < 10.0, 0.0, 60.0)
        late = drive(physics, command).yaw_rate
        prompt = drive(Physics(LENG.inertia, lambda rate: 300.0 * rate), command).yaw_rate
        # The angle that is lost is the lost time at the final rate; a rotor that starts from rest loses 3/2 T by n|n|.
        lost = np.sum(prompt - late) * STEP / 0.2
        time = number(truth, "delay_s" if name == "torque_delay" else "time_constant_s")
        # A jump falls somewhere within a step, so it is known to half a step.
        expected = 1.5 * time if truth.get("shape") == "rotor speed" else time
        assert lost == pytest.approx(expected, abs=STEP / 2)


def test_a_dead_zone_swallows_a_small_command() -> None:
    physics, truth = hide("dead_zone")
    half = number(truth, "half_width_nm")
    assert np.all(drive(physics, 0.99 * half).yaw_rate == 0.0)
    assert drive(physics, 60.0).yaw_rate[-1] > 0.1


def test_reverse_thrust_is_weaker() -> None:
    physics, truth = hide("torque_asymmetry")
    ahead, astern = drive(physics, 60.0).yaw_rate[-1], drive(physics, -60.0).yaw_rate[-1]
    assert -astern / ahead == pytest.approx(number(truth, "reverse_efficiency"), rel=1e-9)


def test_saturation_spares_small_commands_and_cuts_the_largest() -> None:
    physics, _ = hide("torque_saturation")
    assert drive(physics, 20.0).yaw_rate[-1] == pytest.approx(20.0 / 300.0, rel=0.01)
    assert 0.6 < drive(physics, 100.0).yaw_rate[-1] / (100.0 / 300.0) < 0.75


def test_inflow_costs_nothing_at_rest() -> None:
    physics, truth = hide("inflow")
    motion = drive(physics, 64.0)
    assert motion.acceleration[0] == pytest.approx(64.0 / LENG.inertia)
    assert motion.yaw_rate[-1] == pytest.approx(64.0 / (300.0 + 8.0 * number(truth, "coefficient")), rel=1e-9)


def test_a_current_holds_the_idle_vehicle_where_its_moment_vanishes() -> None:
    physics, truth = hide("heading_current", seconds=600.0)
    end = float(drive(physics, 0.0, seconds=600.0).heading[-1])
    assert math.sin(number(truth, "harmonic") * end + number(truth, "phase_rad")) == pytest.approx(0.0, abs=1e-3)


def test_a_tether_balances_the_thrusters_at_an_angle() -> None:
    physics, truth = hide("tether", seconds=1500.0)
    motion = drive(physics, 10.0, seconds=1500.0)
    assert motion.heading[-1] == pytest.approx(10.0 / number(truth, "stiffness_nm_per_rad"), rel=1e-3)


def test_a_wave_comes_again_after_its_period() -> None:
    physics, truth = hide("wave", seconds=120.0)
    motion = drive(physics, 0.0, seconds=120.0)
    period = number(truth, "period_s")
    late = motion.time[motion.time > 60.0]
    before = np.interp(late - period, motion.time, motion.yaw_rate)
    np.testing.assert_allclose(motion.yaw_rate[motion.time > 60.0], before, atol=1e-5)
    assert np.std(motion.yaw_rate) > 1e-3


def test_drag_that_grows_slows_the_turn() -> None:
    for name in ("drag_drift", "drag_step"):
        physics, truth = hide(name)
        expected = 60.0 / (300.0 * (1.0 + number(truth, "fraction")))
        assert drive(physics, 60.0).yaw_rate[-1] == pytest.approx(expected, rel=0.02)


def test_water_that_turns_along_makes_the_turn_faster_in_time() -> None:
    physics, truth = hide("memory", seconds=120.0)
    motion = drive(physics, 60.0, seconds=120.0)
    assert motion.yaw_rate[-1] == pytest.approx(
        60.0 / (300.0 - 300.0 * physics.water_share - physics.water_gain), rel=1e-4
    )
    assert number(truth, "time_constant_s") == physics.water_time


def test_friction_eats_the_same_at_every_rate() -> None:
    physics, truth = hide("coulomb")
    friction = number(truth, "moment_nm")
    for torque in (30.0, 90.0):
        assert drive(physics, torque).yaw_rate[-1] == pytest.approx((torque - friction) / 300.0, rel=1e-6)


def test_a_channel_pushes_or_scales() -> None:
    physics, truth = hide("coupling:sway")
    motion = drive(physics, 0.0)
    sway = channel("sway", np.arange(2 * motion.time.size + 1) * STEP / 2, LENG.time, np.random.default_rng(5))[:-1:2]
    moment = LENG.inertia * motion.acceleration + 300.0 * motion.yaw_rate
    np.testing.assert_allclose(moment, number(truth, "coefficient") * sway, atol=1e-9)
    physics, truth = hide("modulation:voltage")
    assert truth["shape"] == "thrust"
    assert np.all(drive(physics, 0.0).yaw_rate == 0.0)
    assert np.ptp(drive(physics, 60.0).yaw_rate[-800:]) > 0.002


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(KeyError, match="magic"):
        play(Trial(seed=0, effects=("magic",), duration=10.0))
    with pytest.raises(KeyError, match="spoon"):
        play(Trial(seed=0, effects=("coupling:spoon",), duration=10.0))
    with pytest.raises(KeyError, match="wiggle"):
        play(Trial(seed=0, excitation="wiggle", duration=10.0))
