"""The torque that drives a planned yaw rate: the model with its effects, solved for the command."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.feedforward import Feedforward, Plan, feedforward
from incsvr.effects import Signals, Term
from incsvr.model_trace.model import TracedModel
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from incsvr.plant.body import Coupled
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.tracing.of_model import simulated

INERTIA, STEP = 24.0, 0.02
TIME: Array = STEP * np.arange(2000, dtype=np.float64)
RATE = 0.3 * np.sin(2.0 * np.pi * TIME / 20.0)
"""A turn to both sides, from rest and back."""
RATES = np.linspace(-1.0, 1.0, 2001)


def drag(rate: Array) -> Array:
    return np.asarray(9.0 * rate + 26.0 * rate * np.abs(rate))


def model(*terms: Term) -> TracedModel:
    return TracedModel(INERTIA, RATES, drag(RATES), terms, 0.5, 0.2, 1.5, (0.0, 100.0))


def answered(*terms: Term, **channels: Array) -> Feedforward:
    plan = Plan.of(TIME, RATE, None, channels)
    return feedforward(plan, drag(plan.rate), np.full(TIME.size, 0.5), INERTIA, Compensation.of(model(*terms)))


def driven(found: Feedforward, *terms: Term, **channels: Array) -> Array:
    """(n,) the rate that the traced model itself simulates under the torque, sent as early as it says [rad/s]."""
    torque = np.interp(TIME + found.lead, found.time, found.torque)
    signals = Signals(
        step=STEP, start=np.array([0, TIME.size], dtype=np.intp), time=TIME, rate=np.zeros(TIME.size), torque=torque,
        heading=np.zeros(TIME.size), channels=channels,
    )  # fmt: skip
    return simulated(model(*terms), signals)[1]


@pytest.mark.parametrize(
    "term",
    [
        Term("bias_torque", "", (2.0,)),
        Term("inertia", "", (8.0,)),
        Term("dead_zone", "shifted", (1.0,), (1.5,)),
        Term("dead_zone", "step", (1.0,), (1.0,)),
        Term("torque_asymmetry", "", (0.3,)),
        Term("torque_saturation", "smooth limit", (1.0,), (12.0,)),
        Term("torque_saturation", "rounded corner", (1.0,), (0.3, 9.0)),
        Term("torque_saturation", "coefficient", (0.03,)),
        Term("thrust_curve", "", (1.0,), (10.0, 1.8)),
        Term("torque_lag", "moment", (0.5,)),
        Term("torque_lag", "rotor speed", (0.4,)),
        Term("torque_delay", "", (0.3,)),
        Term("inflow", "loaded", (0.5,)),
        Term("coulomb", "", (1.5,), (0.02,)),
        Term("memory", "linear", (-4.0,), (0.2, 3.0)),
        Term("modulation:voltage", "thrust", (0.1,), (16.0,)),
    ],
    ids=lambda term: f"{term.effect} {term.variant}",
)
def test_each_effect_is_inverted(term: Term) -> None:
    channels = {"voltage": 16.0 - 0.05 * TIME} if ":" in term.effect else {}
    found = answered(term, **channels)
    reached = driven(found, term, **channels) - RATE
    unaware = driven(answered(), term, **channels) - RATE
    assert np.sqrt(np.mean(reached**2)) < 0.3 * np.sqrt(np.mean(unaware**2))
    parts = found.inertia_part + found.damping_part + sum(found.effects.values())
    np.testing.assert_allclose(parts, found.torque, atol=1e-9)
    assert (found.low <= found.torque).all()
    assert (found.torque <= found.high).all()


def test_what_cannot_be_made_or_is_not_known_is_a_sentence() -> None:
    limited = answered(Term("torque_saturation", "limit", (1.0,), (4.0,)))
    assert np.abs(limited.torque).max() == 4.0
    assert any("beyond the thrusters" in remark and "saturates" in remark for remark in limited.remarks)
    late = answered(Term("torque_delay", "", (0.3,)))
    assert late.lead == 0.3
    assert any("0.3 s before its time" in remark for remark in late.remarks)
    for name, coefficients, needed in (("coupling:winch", (2.0,), "winch"), ("tether", (2.0, 0.1), "heading")):
        left_out = answered(Term(name, "", coefficients, (0.0,)))
        np.testing.assert_array_equal(left_out.torque, answered().torque)
        assert f"{name} is left out: plan its {needed} too, in channels" in left_out.remarks
    clocked = answered(Term("bias_drift", "", (1.0,)), Term("drag_step", "", (0.3,), (50.0,)))
    assert [remark.split()[0] for remark in clocked.remarks] == ["bias_drift"]


def test_in_a_body_the_other_velocities_and_the_attitude_take_their_part() -> None:
    mass = np.diag([60.0, 80.0, 75.0, 4.0, 12.0, INERTIA])
    mass[1, 5] = mass[5, 1] = 3.0
    body = Coupled(YAW, mass_matrix(mass.ravel().tolist()), ("surge", "sway"))
    surge, sway = 0.5 + 0.1 * np.cos(0.2 * TIME), 0.2 * np.sin(0.3 * TIME)
    plan = Plan.of(TIME, RATE, None, {"surge": surge, "sway": sway})
    bias = Compensation.of(model(Term("bias_torque", "", (2.0,))))
    found = feedforward(plan, drag(plan.rate), np.full(TIME.size, 0.5), INERTIA, bias, coupled=body)
    # N of Fossen (2011), Eq. 6.50, by hand: (Y_v̇ − X_u̇) u v + Y_ṙ (v̇ + u r)
    taken = 20.0 * surge * sway + 3.0 * (0.06 * np.cos(0.3 * TIME) + surge * RATE)
    np.testing.assert_allclose(found.body_part[5:-5], taken[5:-5], atol=1e-3)
    by_itself = answered(Term("bias_torque", "", (2.0,)), surge=surge, sway=sway)
    np.testing.assert_allclose(found.torque - by_itself.torque, found.body_part, atol=1e-9)
    assert np.ptp(found.body_part) > 2.0
