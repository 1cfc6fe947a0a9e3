"""What the learned model is worth to a controller: feed-forward torque, and forecasts without a gyro.

An AUV is driven in open loop, traced and learned. A PI rate controller then follows a smooth plan in moving water, once
alone and once with the learner's torque for the plan. In missions the model forecasts the yaw rate from the commands,
with what it learned before; beside it the last rate, held. Intervals are of 95 %.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from benchmarks.study import Record, grouped, median, run, seeds, share, table
from incsvr.checks import Vehicle as Checked
from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.feedforward import Plan as PlannedMotion
from incsvr.compensation.feedforward import feedforward
from incsvr.forecasting import Experience, Grid, Start, forecast
from incsvr.forecasting.experience import HORIZONS_S as TRIED
from incsvr.learning import checked_learner
from incsvr.numerics import Array, root_mean_square
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.settings import COMMANDED
from incsvr.tracing.result import trace
from incsvr.tracing.run import as_run
from service.recordings.reading import RATE_LIMIT
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import learn, learner_for, samples_of, signals_for
from simulator import effects
from simulator.mission import Mission
from simulator.physics import Physics, Setting
from simulator.plans import OPEN_LOOP, Plan
from simulator.vehicles import TURNING
from simulator.world import play, play_together

VEHICLE = TURNING["auv"]
HIDDEN = ("nothing", "dead_zone", "torque_asymmetry", "torque_lag", "torque_delay", "bias_torque", "inertia")
"""What the vehicle has that its declaration lacks; each can be inverted."""
MISSIONS = ("survey", "waypoints", "circles")  # that are forecast
BEAT_S, BEAT_TICKS, CONTROL_S, SETTLE_S = 0.1, 5, 300.0, 10.0
HORIZONS_S, STARTS = (1.0, 5.0, 20.0), 5
Case = tuple[str, str, int, float]  # feed-forward or forecast; what is hidden, or the mission; seed; length [s]


def examine(case: Case) -> Record:
    """One vehicle under control, or one mission forecast."""
    what, name, seed, seconds = case
    work = _control if what == "feed-forward" else _forecasts
    return {"name": name, "seed": seed} | work(name, seed, seconds)


def _control(name: str, seed: int, seconds: float) -> Record:
    random, hidden = np.random.default_rng([seed, *name.encode()]), Physics()
    if name != "nothing":
        hidden, _ = getattr(effects, name)(Setting(VEHICLE.inertia, VEHICLE.torque, VEHICLE.rate, 1.0, random, seconds))
    time: Array = np.arange(0.0, seconds - 1e-9, BEAT_S, dtype=np.float64)
    levels, sines = (OPEN_LOOP[kind](time / VEHICLE.time, random) for kind in ("telegraph", "multisine"))
    driven = Plan("torque", VEHICLE.torque * np.where(time < 0.5 * seconds, levels, sines))
    log = play(Mission(VEHICLE, "holds", seed, besides=hidden, asked=driven, duration=seconds)).recording
    found = trace([as_run(log.streams())], inertia=VEHICLE.inertia)
    compensation = Compensation.of(found.model) if found.effects else None
    spell = np.searchsorted(np.cumsum(random.uniform(8.0, 20.0, 100)), np.arange(0.0, CONTROL_S - 1e-9, BEAT_S))
    kept = math.exp(-BEAT_S * VEHICLE.bandwidth)
    points = 0.45 * VEHICLE.rate * random.uniform(-1.0, 1.0, 101)[spell]
    wish: Array = np.asarray(lfilter([(1.0 - kept) ** 2], [1.0, -2.0 * kept, kept**2], points))
    gain = 2.0 * VEHICLE.inertia * VEHICLE.bandwidth
    alone = Plan("rate", wish, gain, 0.0, 0.5 * VEHICLE.bandwidth * gain)
    helped = replace(alone, ahead=_ahead(log, compensation, wish))
    steered = Mission(VEHICLE, "rate_control", seed + 1, besides=hidden, duration=CONTROL_S)
    outcomes = play_together(replace(steered, asked=plan) for plan in (alone, helped))
    off = [(each.true("yaw_rate")[::BEAT_TICKS] - wish)[round(SETTLE_S / BEAT_S) :] for each in outcomes]
    alone_and_with = dict(zip(("alone", "with"), map(root_mean_square, off), strict=True))
    return alone_and_with | {"found": [each.effect for each in found.effects]}


def _ahead(log: Recording, compensation: Compensation | None, wish: Array) -> Array:
    """(beats,) the torque that the learner gives for the plan after this log, sent as early as it says [N m]."""
    samples, _ = samples_of(log, signals_for([log], VEHICLE.inertia, RATE_LIMIT), compensation)
    *_, last = learn(samples, learner_for(samples))
    beats, said = BEAT_S * np.arange(wish.size, dtype=np.float64), last.model.predict(wish)
    plan = PlannedMotion.of(beats, wish, None, {})
    found = feedforward(plan, said.damping, said.sigma, VEHICLE.inertia, compensation)
    return np.interp(beats + found.lead, found.time, found.torque)


def _forecasts(kind: str, seed: int, seconds: float) -> Record:
    outcome = play(Mission(VEHICLE, kind, seed, duration=seconds))
    log, signals = outcome.recording, signals_for([outcome.recording], VEHICLE.inertia, RATE_LIMIT)
    streams, samples = log.streams(), samples_of(log, signals, None)[0]
    settings, held = learner_for(samples), signals.torque == COMMANDED
    whole = Grid.of(streams[YAW_RATE], streams[TORQUE], signals.smoothing, signals.sample_period, held)
    checked = Checked(VEHICLE.inertia, settings.rate_range, signals.smoothing)
    state, experience, rows = checked_learner.begin(settings), Experience(), list[list[float]]()
    for first in range(0, len(samples) - settings.batch + 1, settings.batch):
        batch, model = samples.take(slice(first, first + settings.batch)), state.learner.model
        late = first > 0.5 * len(samples) and model.is_trained
        for t in np.linspace(batch.time[0], batch.time[-1], STARTS, endpoint=False).tolist() if late else ():
            node = int(np.searchsorted(whole.time, t))
            for horizon in HORIZONS_S:
                ahead = slice(node, node + round(horizon / whole.step) + 1)
                time, torque, rate = whole.time[ahead], whole.torque[ahead], whole.rate[ahead]
                if not np.isfinite(torque + rate).all() or time[-1] < t + horizon - whole.step:
                    continue
                start, end = Start(float(time[0]), float(rate[0])), float(time[0]) + horizon
                said = forecast(experience, model, VEHICLE.inertia, start, (time, torque), np.array([end]),
                                step=whole.step, sample_period=signals.sample_period)  # fmt: skip
                true = float(np.interp(end, outcome.time, outcome.true("yaw_rate")))
                rows.append([horizon, float(said.rate[0]) - true, float(said.rate_half[0]), start.rate - true])
        state, verdict, _ = checked_learner.learn(settings, checked, state, batch)
        if verdict.learn:
            newest = (whole.time >= batch.time[0] - TRIED[-1]) & (whole.time <= batch.time[-1])
            experience = experience.after(model, VEHICLE.inertia, whole.part(newest))
    return {"forecasts": rows}


def report(records: Sequence[Record]) -> Iterable[str]:
    """The controller with and without the feed-forward; then the forecasts."""
    rows = list[list[object]]()
    for name, own in grouped([each for each in records if "found" in each], "name").items():
        errors = (1e3 * np.median([each[key] for each in own]) for key in ("alone", "with"))
        ratios = [each["with"] / each["alone"] for each in own]
        found = ", ".join(sorted({effect for each in own for effect in each["found"]})) or "–"
        rows.append([name, len(own), *(f"{error:.1f}" for error in errors), median(ratios), found])
    yield table(["hidden", "n", "PI alone [mrad/s]", "with feed-forward [mrad/s]", "ratio", "traced"], rows)
    rows = []
    for name, own in grouped([each for each in records if each.get("forecasts")], "name").items():
        every = np.array([row for each in own for row in each["forecasts"]])
        for horizon in HORIZONS_S:
            _, error, half, hold = every[every[:, 0] == horizon].T
            figures = root_mean_square(error), float(np.median(half)), root_mean_square(hold)
            inside = share(int(np.sum(np.abs(error) <= half)), error.size)
            rows.append([name, f"{horizon:g} s", inside, *(f"{1e3 * figure:.1f}" for figure in figures)])
    head = ["mission", "ahead", "interval contains the truth", "RMS error [mrad/s]", "half interval", "RMS, last rate"]
    yield table(head, rows)


def cases(asked: argparse.Namespace) -> list[Case]:
    """Feed-forward of every kind, then forecasts of every mission."""
    control: list[Case] = [("feed-forward", name, seed, 600.0) for name in HIDDEN for seed in seeds(asked)]
    return control + [("forecast", name, seed, 60.0 * asked.minutes) for name in MISSIONS for seed in seeds(asked)]


if __name__ == "__main__":
    run(
        "control", __doc__, cases, examine, report, first_seed=(2_700_000, "of the vehicles"),
        seeds=(5, "vehicles of each kind"), minutes=(30.0, "length of the missions that are forecast"),
    )  # fmt: skip
