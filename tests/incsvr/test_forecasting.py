"""Forecasts: the mean is the equation's, the deviations are those of many runs, the interval that of earlier errors."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.errors import BadInput
from incsvr.forecasting import Experience, Grid, Start, forecast
from incsvr.forecasting.experience import HORIZONS_S, UNTRIED_WIDENING
from incsvr.forecasting.learned_motion import LearnedDamping
from incsvr.forecasting.other_influences import BY_ITSELF, OtherInfluences
from incsvr.forecasting.over_recordings import Motion, free_run, traced_free_runs
from incsvr.forecasting.propagation import Runs, Water, propagate
from incsvr.learning.learner import Settings
from incsvr.learning.model import Model
from incsvr.model.rows import Factor
from incsvr.numerics import Array
from incsvr.tracing.model import Effect, TracedModel
from service.recordings import samples_from_recording
from simulator import leng
from tests.hidden import acting, lag, memory, stage, trim

INERTIA, STEP = 24.0, 0.05


RATES = np.linspace(-3.0, 3.0, 2001)


def drag(rate: Array) -> Array:
    return np.asarray(9.0 * rate + 26.0 * rate * np.abs(rate))


def ran(
    damping: Array,
    torque: Array,
    rate: float = 0.0,
    sigma: float = 0.0,
    water: Water = Water(0.0, 1.0),  # noqa: B008 -- a frozen value
    effects: Compensation | None = None,
    beside: OtherInfluences = BY_ITSELF,
) -> Runs:
    """One free run of a damping (RATES,) under a torque on steps of STEP, without a doubt of the curve."""
    time: Array = STEP * np.arange(torque.size, dtype=np.float64)
    table = LearnedDamping.curve(lambda rate: np.interp(rate, RATES, damping), 1.2)
    grid = Grid(time, STEP, np.full(time.size, rate), torque, 0.5, beside)
    first, starts = np.zeros(1, dtype=np.intp), np.array([rate])
    return propagate(table, water, INERTIA, grid, first, time.size - 1, starts, sigma, effects)


def test_the_mean_is_that_of_the_equation() -> None:
    time: Array = STEP * np.arange(401, dtype=np.float64)
    torque = 15.0 * np.sin(0.7 * time)
    runs = ran(drag(RATES), torque, 0.3)
    exact = free_run(time, torque, 0.3, inertia=INERTIA, damping=lambda r, _: r * (9.0 + 26.0 * abs(r)))
    assert runs.rate[:, 0] == pytest.approx(exact, abs=1e-4)
    turned = np.concatenate(([0.0], np.cumsum(0.5 * STEP * (exact[1:] + exact[:-1]))))
    assert runs.heading[:, 0] == pytest.approx(turned, abs=5e-4)


def test_the_deviations_are_those_of_many_runs_in_water() -> None:
    rng, count, steps, lasts, size = np.random.default_rng(1), 4000, 400, 1.5, 2.0
    claimed = ran(20.0 * RATES, np.zeros(steps + 1), sigma=0.02, water=Water(size, lasts))
    rate, heading, water = rng.normal(0.0, 0.02, count), np.zeros(count), rng.normal(0.0, size, count)
    stays = np.exp(-STEP / lasts)
    for k in range(1, steps + 1):
        before, rate = rate, rate + STEP * (water - 20.0 * rate) / INERTIA
        heading += 0.5 * STEP * (before + rate)
        water = stays * water + size * np.sqrt(1.0 - stays**2) * rng.standard_normal(count)
        if k in (20, 100, 400):
            assert claimed.rate_sigma[k, 0] == pytest.approx(float(rate.std()), rel=0.06)
            assert claimed.heading_sigma[k, 0] == pytest.approx(float(heading.std()), rel=0.06)


def test_a_damping_that_goes_by_another_velocity_is_its_table() -> None:
    at, beside = np.linspace(0.0, 20.0, 41), np.sin(0.4 * np.linspace(0.0, 20.0, 41))
    tables = drag(RATES) * (1.0 + 0.5 * beside[:, None]) + 4.0 * np.sin(RATES) * beside[:, None] ** 2
    damping = LearnedDamping(float(RATES[1] - RATES[0]), at, tables, 0.0 * tables)
    assert len(damping.rows("yaw_rate")[0]) < 5
    time: Array = STEP * np.arange(401, dtype=np.float64)
    torque, still = 15.0 * np.sin(0.7 * time), np.zeros(1, dtype=np.intp)
    grid = Grid(time, STEP, 0.0 * time, torque, 0.5)
    runs = propagate(damping, Water(0.0, 1.0), INERTIA, grid, still, 400, np.array([0.3]), 0.0)

    def there(rate: float, t: float) -> float:
        size = float(np.interp(t, at, beside))
        return float(drag(np.array(rate))) * (1.0 + 0.5 * size) + 4.0 * float(np.sin(rate)) * size**2

    exact = free_run(time, torque, 0.3, inertia=INERTIA, damping=there)
    assert runs.rate[:, 0] == pytest.approx(exact, abs=2e-3)


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


@pytest.mark.parametrize(
    "effects",
    [
        (lag(0.4), trim(2.0), stage("inertia", "mass", 30.0)),
        (stage("dead_zone", "dead", 1.5), stage("torque_delay", "shift", 0.3), memory(4.0, 3.0)),
        (acting("coulomb", Factor("sign", "yaw_rate", 0.02), value=1.5), stage("torque_asymmetry", "reverse", 0.7)),
        (
            acting("tether", Factor("value", "heading"), value=2.0),
            acting("coupling:sway", Factor("value", "sway"), value=-8.0),
        ),
    ],
    ids=lambda effects: " ".join(effect.name for effect in effects),
)
def test_traced_effects_move_a_forecast_as_they_move_the_engine(effects: tuple[Effect, ...]) -> None:
    time: Array = STEP * np.arange(600, dtype=np.float64)
    torque, sway = 12.0 * np.sin(0.7 * time) + 6.0 * np.sign(np.sin(0.23 * time)), 0.1 * np.sin(0.3 * time)
    model = TracedModel(INERTIA, RATES, drag(RATES), effects, 0.5, 0.2, 1.5, (0.0, 30.0))
    compensation, still = Compensation.of(model), np.zeros(time.size)
    beside = OtherInfluences({"heading": still, "sway": sway})
    runs = ran(drag(RATES), torque, effects=compensation, beside=beside)
    other = np.sin(0.7 * time)  # from which a free run takes nothing but its first value
    streams = {"yaw_rate": (time, other), "torque": (time, torque), "sway": (time, sway), "heading": (time, still)}
    (run,) = traced_free_runs([(Motion(time, torque, time, other), streams)], drag, compensation)
    assert np.abs(runs.rate[:, 0] - run.simulated).max() < 0.01 * np.ptp(run.simulated)
