"""The free run under dry friction, and what it knows of the turn before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import Signals, Term
from incsvr.numerics import Array
from incsvr.tracing.model import TracedModel
from tests.incsvr.turning import instants

FRICTION = 6.0
"""[N m]."""
TABLE = np.linspace(-0.3, 0.3, 61)
RUBBING = TracedModel(
    350.0, TABLE, 100.0 * TABLE, (Term("coulomb", "", (FRICTION,), (0.002,)),), 1.0, 0.5, 6.0, (0.0, 100.0)
)


def under(torque: Array, rate: float = 0.0) -> Signals:
    """A free run of that command from that rate, a sample every 0.05 s."""
    none = np.zeros(torque.size)
    time = instants(torque.size * 0.05)
    return Signals(0.05, np.array([0, torque.size]), time, none + rate, torque, heading=none)


def test_friction_holds_a_vehicle_until_the_torque_exceeds_it() -> None:
    held = RUBBING.simulate(under(np.full(2000, 0.9 * FRICTION)))[1]
    freed = RUBBING.simulate(under(np.full(2000, 2.0 * FRICTION)))[1]
    assert np.max(np.abs(held)) < 2.0 * 0.002  # it creeps within the width of the tanh
    assert freed[-1] == pytest.approx(FRICTION / 100.0, rel=0.01)


def test_friction_ends_a_turn_and_never_reverses_it() -> None:
    rate = RUBBING.simulate(under(np.zeros(2000), rate=0.2))[1]
    assert np.all(np.diff(rate) <= 0.0)
    assert rate[-1] == pytest.approx(0.0, abs=1e-4)
    assert np.min(rate) >= 0.0


def test_a_reversal_costs_the_same_whatever_the_step() -> None:
    """Linearised, so steep a friction stalls every reversal for a step, and coarser steps fall behind."""
    time = instants(120.0)
    torque = 60.0 * np.sign(np.sin(2.0 * np.pi * (5.0 * np.floor(time / 0.25) * 0.05) / 9.7))
    fine = RUBBING.simulate(under(torque))[1]
    coarse = replace(under(torque[::5]), step=0.25, time=time[::5])
    assert np.sqrt(np.mean((RUBBING.simulate(coarse)[1] - fine[::5]) ** 2)) < 0.01 * np.std(fine)


def test_a_free_run_knows_the_command_and_the_turn_before_it() -> None:
    """From the middle of a recording it goes on with the thrust and the water as the turn before has left them."""
    terms = (Term("torque_lag", "moment", (2.0,)), Term("memory", "linear", (-40.0,), (0.2, 8.0)))
    model = replace(RUBBING, terms=terms)
    signals = under(60.0 * np.sin(0.6 * instants(120.0)))
    index, rate = model.simulate(signals)
    signals = replace(signals, rate=rate[index])
    later = [slice(1000, 1400), slice(1500, 2400)]
    whole = np.concatenate([signals.rate[span] for span in later])
    known = model.simulate(signals, later)[1]
    forgotten = model.simulate(signals.pieces(later))[1]
    assert np.max(np.abs(known - whole)) < 1e-6 + 0.002 * np.max(np.abs(whole))
    assert np.max(np.abs(forgotten - whole)) > 0.05 * np.max(np.abs(whole))


def test_a_run_that_diverged_finds_some_damping_and_does_not_warn() -> None:
    assert np.isfinite(RUBBING.drag()(np.array([np.nan, np.inf, -1e9]))).all()
