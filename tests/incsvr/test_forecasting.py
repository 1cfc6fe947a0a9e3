"""Forecasts: the mean is the equation's, the deviations are those of many runs, the interval that of earlier errors."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.effects import Signals, Term, candidates
from incsvr.errors import BadInput
from incsvr.forecasting import Experience, Grid, Start, forecast
from incsvr.forecasting.damping_tables import TABLE_NODES, Curve
from incsvr.forecasting.effects_ahead import EffectsAhead
from incsvr.forecasting.experience import HORIZONS_S, UNTRIED_WIDENING
from incsvr.forecasting.free_runs import free_runs
from incsvr.forecasting.other_influences import OtherInfluences
from incsvr.forecasting.propagation import propagate
from incsvr.free_run.integrator import free_run
from incsvr.free_run.several_velocities import free_run as free_run_among
from incsvr.learning.learner import Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.signals import SignalSettings, synchronise
from incsvr.tracing.model import TracedModel
from service.recordings import samples_from_recording
from simulator import leng
from simulator.vehicles import planar
from tests import worlds

INERTIA, STEP = 24.0, 0.05


def line(slope: float, sigma: float = 0.0, disturbance: float = 0.0, lasts: float = 1.0) -> Curve:
    rates = np.linspace(-2.5, 2.5, TABLE_NODES)
    return Curve(
        -2.5, float(rates[1] - rates[0]), slope * rates, np.full(TABLE_NODES, slope), np.full(TABLE_NODES, sigma),
        INERTIA, disturbance, lasts,
    )  # fmt: skip


def test_the_mean_is_that_of_the_equation() -> None:
    time: Array = STEP * np.arange(401, dtype=np.float64)
    torque = 15.0 * np.sin(0.7 * time)
    rates = np.linspace(-2.5, 2.5, TABLE_NODES)
    damping = 9.0 * rates + 26.0 * rates * np.abs(rates)
    step = float(rates[1] - rates[0])
    curve = Curve(-2.5, step, damping, np.gradient(damping, step), 0.0 * rates, INERTIA, 0.0, 1.0)
    runs = propagate(curve, np.array([0.3]), 0.0, torque[:, None], STEP)
    exact = free_run(time, torque, 0.3, inertia=INERTIA, damping=lambda r: r * (9.0 + 26.0 * abs(r)))
    assert runs.rate[:, 0] == pytest.approx(exact, abs=2e-4)
    turned = np.concatenate(([0.0], np.cumsum(0.5 * STEP * (exact[1:] + exact[:-1]))))
    assert runs.heading[:, 0] == pytest.approx(turned, abs=2e-3)


def test_the_deviations_are_those_of_many_runs_in_water() -> None:
    rng, count, steps, lasts, size = np.random.default_rng(1), 4000, 400, 1.5, 2.0
    curve = line(20.0, disturbance=size, lasts=lasts)
    claimed = propagate(curve, np.zeros(1), 0.02, np.zeros((steps + 1, 1)), STEP)
    rate, heading, water = rng.normal(0.0, 0.02, count), np.zeros(count), rng.normal(0.0, size, count)
    stays = np.exp(-STEP / lasts)
    for k in range(1, steps + 1):
        before, rate = rate, rate + STEP * (water - 20.0 * rate) / INERTIA
        heading += 0.5 * STEP * (before + rate)
        water = stays * water + size * np.sqrt(1.0 - stays**2) * rng.standard_normal(count)
        if k in (20, 100, 400):
            assert claimed.rate_sigma[k, 0] == pytest.approx(float(rate.std()), rel=0.06)
            assert claimed.heading_sigma[k, 0] == pytest.approx(float(heading.std()), rel=0.06)


@cache
def learned(until: float) -> tuple[Experience, Model, Grid]:
    """What the Leng's first training run teaches until then."""
    streams = leng.recording("T1", 7).streams()
    signals, settings = leng.SIGNALS, Settings()
    grid = Grid.of(streams["yaw_rate"], streams["torque"], signals.smoothing, signals.sample_period, held=False)
    experience, model = Experience(), Model.untrained(settings.gamma, settings.C, settings.epsilon)
    samples = leng.experiment(7).T1
    for number, iteration in enumerate(samples_from_recording.learn(samples, settings)):
        batch = samples.take(slice(number * settings.batch, (number + 1) * settings.batch))
        if batch.time[-1] > until:
            break
        part = (grid.time >= batch.time[0] - HORIZONS_S[-1]) & (grid.time <= batch.time[-1])
        experience = experience.after(model, leng.INERTIA, grid.part(part))
        model = iteration.model
    return experience, model, grid


def test_what_was_tried_makes_the_interval_and_survives_a_restart() -> None:
    experience, model, grid = learned(300.0)
    ahead = np.array(HORIZONS_S)
    assert np.array(Experience().widening(ahead)) == pytest.approx(UNTRIED_WIDENING)
    assert all(len(scores) for scores in experience.scores)
    again = Experience.from_dict(json.loads(json.dumps(experience.to_dict())))
    assert np.array_equal(again.widening(ahead), experience.widening(ahead))
    assert experience.widening(np.array([300.0]))[0] == experience.widening(ahead)[0].max()
    held, count = np.zeros(4), 0
    for first in np.flatnonzero(grid.time > 300.0)[: -round(62.0 / grid.step) : round(7.0 / grid.step)]:
        start = Start(float(grid.time[first]), float(grid.rate[first]))
        last = first + round(60.0 / grid.step)
        if not np.isfinite(grid.rate[first : last + 1]).all():
            continue
        at = start.time + np.array([1.0, 5.0, 20.0, 60.0])
        known = grid.time[first : last + 2], grid.torque[first : last + 2]
        said = forecast(
            experience, model, leng.INERTIA, start, known, at, step=grid.step, sample_period=grid.sample_period
        )
        held += np.abs(said.rate - np.interp(at, grid.time, grid.rate)) <= said.rate_half
        assert said.worth.all()
        count += 1
    assert count >= 8
    assert (held / count >= 0.8).all()


def test_what_cannot_be_forecast_is_refused() -> None:
    experience, model, grid = learned(300.0)
    start, known = Start(100.0, 0.1), (grid.time, grid.torque)
    for at in (np.array([99.0]), np.array([110.0, 105.0]), np.empty(0), np.array([1e5])):
        with pytest.raises(BadInput):
            forecast(experience, model, leng.INERTIA, start, known, at, step=0.06, sample_period=0.6)
    with pytest.raises(BadInput, match="nothing was learned yet"):
        forecast(Experience(), model, leng.INERTIA, start, known, np.array([101.0]), step=0.06, sample_period=0.6)


TERMS = {
    "lag, dead zone and delay": (
        Term("torque_lag", "moment", (0.4,)), Term("dead_zone", "shifted", (1.0,), (8.0,)),
        Term("torque_delay", "", (0.3,)),
    ),
    "another inertia and a constant moment": (Term("inertia", "", (90.0,)), Term("bias_torque", "", (9.0,))),
    "dry friction": (Term("coulomb", "sharp", (6.0,), (1e-3,)),),
    "water that turns along": (Term("memory", "linear", (-120.0,), (0.1, 5.0)),),
    "a current": (Term("heading_current", "1", (10.0, 5.0)),),
    "damping by a channel": (Term("modulation:depth", "damping", (0.5,), (1.0,)),),
}  # fmt: skip


@pytest.mark.parametrize("terms", TERMS.values(), ids=TERMS)
def test_with_effects_the_mean_is_that_of_the_traced_model(terms: tuple[Term, ...]) -> None:
    _, model, grid = learned(300.0)
    part = grid.part((grid.time > 200.0) & (grid.time < 260.0))
    heading = part.step * np.cumsum(part.rate)
    depth = 1.0 + np.sin(0.2 * part.time)
    grid = replace(part, beside=OtherInfluences({"heading": heading, "depth": depth}))
    rates = np.linspace(-0.5, 0.5, 2001)
    known = {effect.key for effect in candidates(["depth"])}
    terms = tuple(replace(t, variant=t.variant if f"{t.effect}/{t.variant}" in known else "") for t in terms)
    traced = TracedModel(
        leng.INERTIA, rates, model.predict(rates).damping, terms, 1.0, 0.3, 5.0, (grid.time[0], grid.time[-1])
    )
    first, steps = np.array([150, 200]), 300
    rows = first + np.arange(steps + 1)[:, None]
    ahead = EffectsAhead(Compensation.of(traced), grid)
    runs = free_runs(model, leng.INERTIA, 0.25, grid, rows, grid.rate[first], 0.0, ahead)
    mean = 0.5 * (grid.torque + np.append(grid.torque[1:], grid.torque[-1]))
    signals = Signals(
        grid.step, np.array([0, grid.time.size]), grid.time, grid.rate, mean, grid.beside.channels, heading,
        inertia=leng.INERTIA,
    )  # fmt: skip
    _, exact = traced.simulate(signals, [slice(k, k + steps + 1) for k in first.tolist()])
    _, without = replace(traced, terms=()).simulate(signals, [slice(k, k + steps + 1) for k in first.tolist()])
    assert runs.rate.T.ravel() == pytest.approx(exact, abs=1e-3)
    assert np.abs(without - exact).max() > 10.0 * np.abs(runs.rate.T.ravel() - exact).max()


def test_among_other_velocities_the_mean_is_that_of_the_free_run() -> None:
    run = worlds.planar(910104, 120.0)
    inertia, streams = planar(910104).inertia, run.streams()
    settings = Settings(policy="weighted", own="yaw_rate", others=("surge", "sway"))
    signals = SignalSettings(inertia=inertia, channels=("surge", "sway"))
    samples, _ = synchronise(signals, streams)
    model = list(samples_from_recording.learn(samples, settings))[-1].model
    bare = Grid.of(streams["yaw_rate"], streams["torque"], 0.12, 0.6, held=False)
    grid = bare.among(streams, ("surge", "sway"), None, 0.12)
    first, steps = int(np.searchsorted(grid.time, 40.0)), round(30.0 / grid.step)
    rows = first + np.arange(steps + 1)[:, None]
    runs = free_runs(model, inertia, 0.3, grid, rows, grid.rate[[first]], 0.0)
    beside = np.column_stack([grid.beside.channels[name][rows[:, 0]] for name in ("surge", "sway")])
    exact = free_run_among(
        grid.time[rows[:, 0]], grid.torque[rows[:, 0]], float(grid.rate[first]), beside, None, inertia, model
    )
    assert runs.rate[:, 0] == pytest.approx(exact, abs=0.02 * float(np.ptp(exact)))
