"""The world against independent references: SciPy's integrator, Leng's own equation, conservation, and itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from incsvr.numerics import Array
from incsvr.plant.attitude import kinematics
from incsvr.plant.mass_and_coriolis import coriolis_matrix
from simulator.mission import EFFECTS, LISTS, ON_CHANNEL, TICK_S, Mission
from simulator.plans import OPEN_LOOP, PLANS, Plan
from simulator.sensors import CHANNELS, Sensor
from simulator.vehicles import BODIES, SECOND, TURNING, Vehicle, rov
from simulator.world import Outcome, play, play_together

RATE = 5


def textbook(vehicle: Vehicle, outcome: Outcome, end: float) -> Array:
    """ν and the angles at a time [s], by SciPy from Fossen's matrices and the efforts that were commanded."""
    efforts = outcome.motion[:, 9:]

    def slope(t: float, x: Array) -> Array:
        velocity, angles = x[:6], x[6:]
        righting = vehicle.righting * np.array([math.cos(angles[1]) * math.sin(angles[0]), math.sin(angles[1])])
        force = (
            efforts[min(int(t / TICK_S + 1e-9), len(efforts) - 1)] - coriolis_matrix(vehicle.mass, velocity) @ velocity
        )
        force = force - vehicle.linear * velocity - vehicle.quadratic * velocity * np.abs(velocity)
        force[3:5] -= righting
        return np.concatenate([np.linalg.solve(vehicle.mass, force), (kinematics(*angles) @ velocity)[3:]])

    x, beat = np.zeros(9), 0.1
    for k in range(round(end / beat)):  # the efforts jump at the beats
        x = solve_ivp(slope, (k * beat, (k + 1) * beat - 1e-9), x, rtol=1e-9, atol=1e-11).y[:, -1]
    return x


def test_six_degrees_of_freedom_agree_with_an_independent_integration() -> None:
    vehicle = rov(np.random.default_rng(1))
    outcome = play(Mission(vehicle, "holds", 4, duration=12.0, water=0.0))
    off = outcome.motion[round(10.0 / TICK_S), :9] - textbook(vehicle, outcome, 10.0)
    assert np.max(np.abs(outcome.motion[:, :6])) > 0.5
    assert np.max(np.abs((off + np.pi) % (2.0 * np.pi) - np.pi)) < 2e-4


def test_without_damping_energy_and_momentum_are_kept() -> None:
    """A body that is pushed for a while and then glides, turning about all axes."""
    vehicle = replace(rov(np.random.default_rng(2)), linear=np.zeros(6), quadratic=np.zeros(6), righting=0.0)
    pushed = np.where(np.arange(200) < 10, 1.0, 0.0)
    others = {name: 0.2 * largest * pushed for name, largest in vehicle.effort.items() if name != "yaw"}
    plan = Plan("torque", 0.2 * vehicle.torque * pushed, others=others)
    velocity = play(Mission(vehicle, "holds", 1, duration=20.0, water=0.0, asked=plan)).motion[60:, :6]
    energy = 0.5 * np.einsum("ni,ij,nj->n", velocity, vehicle.mass, velocity)
    momentum = velocity @ vehicle.mass
    assert np.ptp(energy) < 1e-4 * energy[0]
    assert np.ptp(np.linalg.norm(momentum[:, :3], axis=1)) < 1e-4 * np.linalg.norm(momentum[0, :3])
    assert np.ptp(velocity[:, 3]) > 0.05  # it tumbles


def test_who_is_played_beside_changes_nothing() -> None:
    one = Mission(SECOND["torpedo"], "waypoints", 5, ("torque_lag",), "second", duration=20.0)
    beside = Mission(rov(np.random.default_rng(1)), "holds", 9, duration=15.0)
    alone, together = play(one), play_together([beside, one])[1]
    assert alone.truth == together.truth
    for name, values in alone.recording.columns.items():
        np.testing.assert_allclose(together.recording.columns[name], values, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("of", LISTS)
def test_every_effect_turns_the_vehicle_and_none_of_size_zero_does(of: str) -> None:
    names = [(name,) for name in EFFECTS] + [(f"{kind}:{CHANNELS[0]}",) for kind in ON_CHANNEL]
    plain = Mission(TURNING["auv"], "multisine", 6, of=of, duration=40.0, water=0.0, channels=CHANNELS[:1])
    hidden = [replace(plain, hidden=each) for each in names]
    sound, nothing, *found = play_together([plain, replace(hidden[0], size=0.0), *hidden])
    r = sound.true("yaw_rate")
    assert np.array_equal(nothing.true("yaw_rate"), r)
    assert nothing.truth == {}
    for each in found:
        (name,) = each.mission.hidden
        assert each.truth[name]
        assert np.std(each.true("yaw_rate") - r) > 0.004 * np.std(r), name


def test_an_effect_comes_on_at_its_onset() -> None:
    sound, broken = play_together(
        Mission(TURNING["auv"], "telegraph", 6, hidden, onset=20.0, duration=40.0)
        for hidden in ((), ("inertia", "bias_torque"))
    )
    off = np.abs(sound.true("yaw_rate") - broken.true("yaw_rate"))
    assert np.max(off[: round(20.0 / TICK_S) + 1]) == 0.0
    assert np.max(off[round(20.0 / TICK_S) + 1 :]) > 0.01


@pytest.mark.parametrize("kind", [*PLANS, *OPEN_LOOP])
def test_every_plan_stays_within_the_thrusters(kind: str) -> None:
    vehicles = [TURNING["rov"], *(make(np.random.default_rng(3)) for make in BODIES.values())]
    for outcome in play_together([Mission(each, kind, 1, duration=40.0) for each in vehicles]):
        vehicle, efforts = outcome.mission.vehicle, outcome.motion[:, 9:]
        assert np.all(np.isfinite(outcome.motion))
        assert np.max(np.abs(efforts[:, 5])) <= vehicle.torque * (1.0 + 1e-9)
        commands = outcome.recording.streams()["torque"] if "yaw" in vehicle.effort else None
        if commands is not None:
            assert commands[0][1] == 0.1
            assert np.array_equal(commands[1], efforts[::RATE, 5])


def test_a_sensor_samples_at_its_rate_and_says_so_later() -> None:
    """A gyro that is late by 60 ms shows what was 60 ms ago."""
    gyro = Sensor("yaw_rate", 7.0, latency=0.06, phase=0.3)
    outcome = play(Mission(TURNING["rov"], "bursts", 3, duration=40.0, sensing=lambda _, __: (gyro,)))
    time, values = outcome.recording.streams()["yaw_rate"]
    np.testing.assert_allclose(np.diff(time), 1.0 / 7.0, atol=2e-6)
    true = outcome.true("yaw_rate")
    off = [np.max(np.abs(values - np.interp(time - late, outcome.time, true))) for late in (0.06, 0.0)]
    assert off[0] < 0.005 < off[1]


def test_a_current_is_seen_over_ground_and_not_felt() -> None:
    still, carried = play_together(
        Mission(TURNING["auv"], "circles", 3, duration=30.0, current=current) for current in ((0.0, 0.0), (0.3, -0.1))
    )
    assert np.array_equal(still.true("yaw_rate"), carried.true("yaw_rate"))
    psi = carried.true("heading")
    np.testing.assert_allclose(carried.true("surge"), 0.3 * np.cos(psi) - 0.1 * np.sin(psi), atol=1e-3)
    np.testing.assert_allclose(carried.true("sway"), -0.3 * np.sin(psi) - 0.1 * np.cos(psi), atol=1e-3)
