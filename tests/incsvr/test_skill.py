"""Multi-step errors and the trivial models, against a vehicle whose motion is known."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import Signals
from incsvr.tracing.model import TracedModel
from incsvr.tracing.skill import HORIZONS, ahead, beats_zero, horizons, proven, trivial

STEP, INERTIA, DRAG, SCALE = 0.02, 10.0, 20.0, 1.0


def turning(drag: float) -> tuple[Signals, TracedModel]:
    """I ṙ + `drag` r = τ, integrated exactly between steps of the torque; the model holds DRAG."""
    time = np.linspace(0.0, 400.0, 20_001)
    torque = 8.0 * np.sin(time) + 5.0 * np.sin(0.37 * time)
    kept = np.exp(-drag * STEP / INERTIA)
    rate = np.zeros(time.size)
    for k in range(time.size - 1):
        rate[k + 1] = kept * rate[k] + (1.0 - kept) * 0.5 * (torque[k] + torque[k + 1]) / drag
    start = np.array([0, time.size], dtype=np.intp)
    signals = Signals(
        STEP, start, time, rate, torque, heading=np.zeros(time.size), inertia=INERTIA, scale=SCALE, block=0.1
    )
    table = np.linspace(-2.0, 2.0, 101)
    return signals, TracedModel(INERTIA, table, DRAG * table, (), 1.0, 0.1, SCALE, (0.0, float(time[-1])))


def test_the_true_model_errs_next_to_nothing_and_holding_errs_by_what_changed() -> None:
    signals, model = turning(DRAG)
    found = ahead([model], signals, STEP, [[slice(0, 10_000), slice(10_000, 20_001)]], SCALE)
    assert len(found) == len(HORIZONS)
    for horizon, each in zip(HORIZONS, found, strict=True):
        assert np.max(np.abs(each.error)) < 2e-3
        count = round(horizon * SCALE / STEP)
        assert each.error.size == sum((n - 1) // count if n > count else 0 for n in (10_000, 10_001))
        np.testing.assert_allclose(each.change[0], signals.rate[count] - signals.rate[0], atol=1e-12)
        np.testing.assert_allclose(each.rate[0], signals.rate[count])


def test_a_wrong_model_errs_more_the_farther_it_looks() -> None:
    signals, model = turning(0.5 * DRAG)
    found = ahead([model], signals, STEP, [signals.runs()], SCALE)
    errors = [errors["after"] for errors in horizons(found, found).values()]
    assert errors[:3] == sorted(errors[:3])  # beyond two time scales it has forgotten how it began
    assert errors[2] > 1.3 * errors[0] > 0.0


def test_a_model_worse_than_zero_proves_nothing() -> None:
    rates = (np.array([0.1, 0.2, -0.2]), np.array([0.3, 0.3]))
    assert trivial(rates)["zero"]["free_run_rmse"] == pytest.approx(np.sqrt(0.27 / 5.0))
    assert trivial(rates)["hold"]["free_run_rmse"] == pytest.approx(np.sqrt(0.10 / 5.0))
    change = {"free_run_rmse": {"high": -0.1}, "torque_rmse": {"high": 0.1}}
    error = {"change": change, "trivial": trivial(rates), "after": {"free_run_rmse": 0.1}}
    assert beats_zero(error)
    assert proven(error, closed_loop=False)
    assert not proven(error, closed_loop=True)
    worse = error | {"after": {"free_run_rmse": 0.3}}
    assert not beats_zero(worse)
    assert not proven(worse, closed_loop=False)
