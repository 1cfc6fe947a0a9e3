"""Torque and yaw rate that are apart by part of a sample are no effect of the vehicle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.acceptance import against_physics
from incsvr.tracing.weak.evidence import gain_beside_slip, gain_of
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing, settle
from incsvr.tracing.weak.posing import pose

INERTIA, PERIOD, FINE = 350.0, 0.05, 0.005


def played(seed: int, late: float, loss: float = 0.0) -> Run:
    """A telegraph through a filter of 0.6 s, recorded at 20 Hz; the thrust comes `late` and loses `loss` r √|a|."""
    random = np.random.default_rng(seed)
    count = round(500.0 / FINE)
    asked = np.repeat(random.choice([-60.0, 60.0], count), round(4.0 / FINE))[:count]
    command: Array = np.empty(count)
    rate: Array = np.zeros(count)
    value = 0.0
    for k in range(count):
        value += FINE / 0.6 * (asked[k] - value)
        command[k] = value
    behind = round(late / FINE)
    for k in range(count - 1):
        thrust = command[max(k - behind, 0)]
        thrust -= loss * rate[k] * np.sqrt(abs(thrust))
        rate[k + 1] = rate[k] + FINE / INERTIA * (thrust - 130.0 * rate[k] - 400.0 * rate[k] * abs(rate[k]))
    every = round(PERIOD / FINE)
    torque = command[::every] + 2.0 * random.normal(size=count // every)
    seen = rate[::every] + 1e-4 * random.normal(size=count // every)
    return Run("slip", PERIOD * np.arange(count // every, dtype=np.float64), seen, torque, {})


def inflow(run: Run) -> tuple[float, float]:
    """2 Δℓ of inflow as it is, and beside a slip."""
    problem = pose([run], INERTIA, [])
    found: Hypothesis = settle(problem, [(catalogue()["inflow"], (), ())], nothing(problem))
    return gain_of(problem, found, 0), gain_beside_slip(problem, found, 0)


def test_a_slip_within_a_sample_is_no_inflow() -> None:
    plain, beside = inflow(played(1, late=0.02))
    assert plain > 30.0
    assert beside < 0.3 * plain


def test_inflow_is_no_slip() -> None:
    """Under two levels of thrust a slip explains a good part of it, but not all."""
    _, beside = inflow(played(1, late=0.0, loss=5.0))
    assert beside > 100.0


@pytest.mark.parametrize(("apart", "forbidden"), [(-0.02, False), (-0.15, True)])
def test_a_slip_may_stand_beside_a_lag_though_it_goes_the_other_way(apart: float, forbidden: bool) -> None:
    """Without it a lag's shape would have to take in what the recorder did; more than that is no recorder's."""
    effects, problem = catalogue(), pose([played(1, late=0.0)], INERTIA, [])
    pair = [(effects["torque_lag/moment"], (0.4,), (0.4,)), (effects["torque_delay"], (0.02,), (apart,))]
    found = settle(problem, pair, nothing(problem), passes=1)
    values = zip(found.terms, ((0.4,), (apart,)), strict=True)
    found = replace(found, terms=tuple(replace(term, coefficients=value) for term, value in values))
    assert (against_physics(problem, found) is not None) == forbidden
