"""The torque that drives a planned yaw rate: the model with its effects, solved for the command."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.feedforward import Feedforward, Plan, feedforward
from incsvr.forecasting.over_recordings import Motion, traced_free_runs
from incsvr.model.rows import Factor
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from incsvr.plant.body import Coupled
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.tracing.model import Effect, TracedModel
from tests.hidden import acting, lag, memory, stage, trim

INERTIA, STEP = 24.0, 0.02
TIME: Array = STEP * np.arange(2000, dtype=np.float64)
RATE = 0.3 * np.sin(2.0 * np.pi * TIME / 20.0)
"""A turn to both sides, from rest and back."""
RATES = np.linspace(-1.0, 1.0, 2001)


def drag(rate: Array) -> Array:
    return np.asarray(9.0 * rate + 26.0 * rate * np.abs(rate))


def model(*effects: Effect) -> TracedModel:
    return TracedModel(INERTIA, RATES, drag(RATES), effects, 0.5, 0.2, 1.5, (0.0, 100.0), top=10.0)


def answered(*effects: Effect, **channels: Array) -> Feedforward:
    plan = Plan.of(TIME, RATE, None, channels)
    return feedforward(plan, drag(plan.rate), np.full(TIME.size, 0.5), INERTIA, Compensation.of(model(*effects)))


def driven(found: Feedforward, *effects: Effect, **channels: Array) -> Array:
    """(n,) the rate that the engine simulates under the torque, sent as early as it says, less the plan's [rad/s]."""
    torque = np.interp(TIME + found.lead, found.time, found.torque)
    streams = {"yaw_rate": (TIME, RATE), "torque": (TIME, torque)}
    streams |= {name: (TIME, values) for name, values in channels.items()}
    motion = Motion(*streams["torque"], *streams["yaw_rate"])
    (run,) = traced_free_runs([(motion, streams)], drag, Compensation.of(model(*effects)))
    return run.error


@pytest.mark.parametrize(
    "effect",
    [
        trim(2.0),
        stage("inertia", "mass", 32.0),
        stage("dead_zone", "dead", 1.5),
        stage("torque_asymmetry", "reverse", 0.75),
        stage("thrust_curve", "exponent", 1.8),
        lag(0.5),
        stage("torque_lag", "spin", 0.4),
        stage("torque_delay", "shift", 0.3),
        acting("inflow", Factor("value", "yaw_rate"), Factor("root", "torque"), value=3.0),
        acting("coulomb", Factor("sign", "yaw_rate", 0.02), value=1.5),
        memory(4.0, 3.0),
        acting("modulation:voltage", Factor("about", "voltage", 16.0), Factor("value", "torque"), value=-0.1),
    ],
    ids=lambda effect: " ".join((effect.name, *effect.theta)),
)
def test_each_effect_is_inverted(effect: Effect) -> None:
    channels = {"voltage": 16.0 - 0.05 * TIME} if ":" in effect.name else {}
    found = answered(effect, **channels)
    reached, unaware = driven(found, effect, **channels), driven(answered(), effect, **channels)
    assert np.sqrt(np.mean(reached**2)) < 0.3 * np.sqrt(np.mean(unaware**2))
    parts = found.inertia_part + found.damping_part + sum(found.effects.values())
    np.testing.assert_allclose(parts, found.torque, atol=1e-9)
    assert (found.low <= found.torque).all()
    assert (found.torque <= found.high).all()


def test_what_cannot_be_made_or_is_not_known_is_a_sentence() -> None:
    limited = answered(stage("torque_saturation", "limit", 4.0))
    assert np.abs(limited.torque).max() == pytest.approx(4.0)
    assert any("beyond the thrusters: the thrust is cut at a limit" in remark for remark in limited.remarks)
    late = answered(stage("torque_delay", "shift", 0.3))
    assert late.lead == 0.3
    assert any("0.3 s before its time" in remark for remark in late.remarks)
    for name, needed in (("coupling:winch", "winch"), ("tether", "heading")):
        left_out = answered(acting(name, Factor("value", needed), value=2.0))
        np.testing.assert_array_equal(left_out.torque, answered().torque)
        assert f"{name} is left out: plan its {needed} too, in channels" in left_out.remarks
    drift, jump = (acting(name, Factor("value", "time"), value=1.0) for name in ("bias_drift", "drag_step"))
    assert [remark.split()[0] for remark in answered(drift, jump).remarks] == ["bias_drift"]


def test_in_a_body_the_other_velocities_and_the_attitude_take_their_part() -> None:
    mass = np.diag([60.0, 80.0, 75.0, 4.0, 12.0, INERTIA])
    mass[1, 5] = mass[5, 1] = 3.0
    body = Coupled(YAW, mass_matrix(mass.ravel().tolist()), ("surge", "sway"))
    surge, sway = 0.5 + 0.1 * np.cos(0.2 * TIME), 0.2 * np.sin(0.3 * TIME)
    plan = Plan.of(TIME, RATE, None, {"surge": surge, "sway": sway})
    bias = Compensation.of(model(trim(2.0)))
    found = feedforward(plan, drag(plan.rate), np.full(TIME.size, 0.5), INERTIA, bias, coupled=body)
    # N of Fossen (2011), Eq. 6.50, by hand: (Y_v̇ − X_u̇) u v + Y_ṙ (v̇ + u r)
    taken = 20.0 * surge * sway + 3.0 * (0.06 * np.cos(0.3 * TIME) + surge * RATE)
    np.testing.assert_allclose(found.body_part[5:-5], taken[5:-5], atol=1e-3)
    by_itself = answered(trim(2.0), surge=surge, sway=sway)
    np.testing.assert_allclose(found.torque - by_itself.torque, found.body_part, atol=1e-9)
    assert np.ptp(found.body_part) > 2.0
