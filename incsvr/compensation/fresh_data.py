"""Whether effects pay on data that nobody has looked at.

Two models are fitted to the data before, one with the effects as they were found and one without, and foretell each
rise of the yaw rate in the fresh data from what is known before it: what that says holds also where a controller closes
the loop (bets.py). For people, two learners go over the data before, too, and their models run freely over the fresh
data, from its first measured yaw rate, with the torque and the channels alone. In open loop there are bets on these
free runs, too, but only against the effects: where a controller answers the water unseen, free runs favour, for
minutes, effects that are not there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.bets import evidence, final_log_wealth, score
from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation
from incsvr.compensation.freeing import takes_torque
from incsvr.compensation.promotion import Comparison
from incsvr.effects import Effect, Term
from incsvr.errors import BadInput
from incsvr.learning import learner
from incsvr.numerics import Array, Streams
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings, synchronise
from incsvr.tracing import innovations
from incsvr.tracing.cells import Cut, cut
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, fit, score_on
from incsvr.tracing.hypothesis import Hypothesis, Part
from incsvr.tracing.model import TracedModel, model_of
from incsvr.tracing.run import Run, stream
from incsvr.tracing.statistics import change_of_rms, rms
from incsvr.tracing.thresholds import INDEPENDENT_BLOCK_SCALES
from incsvr.tracing.torque_nature import TorqueNature

MIN_CELLS_BEFORE = 100
"""Cells of data before the fresh data, ten for each coefficient of damping and noise: below it nothing is determined.
How well they are known the bets show; a count of time scales would refuse a vehicle in circles."""
MIN_TURN_SHARE = 0.2
"""Part of how much it turned before by which a vehicle turns at least that tells anything of its effects."""
FREE_RUN_BLOCK_SCALES = 1.0
"""Time scales of the motion in a block of the bets on free runs, whose errors last as long as the motion does."""
BET_BLOCK_SCALES = 0.5
"""Time scales of the motion in a block of the bets: whitened water lasts for a few cells."""

STEPS_PER_SCALE = 20.0
"""Steps of a free run in a time scale of the motion."""
COMMANDED_TORQUE = TorqueNature(held=True, noisy=False, closed=True)
"""A torque that the vehicle is told to apply, which a controller may have made."""


def compare_on_fresh_data(
    streams: Streams,
    fresh: float,
    signals: SignalSettings,
    settings: learner.Settings,
    without: Compensation | None,
    effects: Compensation,
    closed: bool = True,
) -> Comparison:
    """Free runs over what came from the time `fresh` [s] on, of models learned from what came before.

    Args:
        streams: name → (stamps [s], values); yaw rate, torque and the channels that the effects read.
        fresh: where the fresh data begins [s].
        signals, settings: how the learner learns.
        without: the effects that the model has anyway; None for none.
        effects: those to compare with.
        closed: a controller may have closed the loop: then a torque that answers the water makes any free run say
            nothing, and bets are on the forecasts from cell to cell alone.

    Raises:
        BadInput: either side of `fresh` holds too little.
    """
    before = {name: (t[t < fresh], values[t < fresh]) for name, (t, values) in streams.items()}
    run = as_run({name: (t[t >= fresh], values[t >= fresh]) for name, (t, values) in streams.items()})
    told = _forecasts(streams, fresh, without, effects)
    bare = replace(effects.model, terms=() if without is None else without.model.terms)
    plain_model = _with_learned_damping(bare, before, signals, settings, without, told.plain)
    better_model = _with_learned_damping(effects.model, before, signals, settings, effects, told.better)
    plain, step = _free_run(run, plain_model)
    better, _ = _free_run(run, better_model)
    if not np.isfinite(rms(plain)) or not np.isfinite(rms(better)):
        raise BadInput("a channel that the effects read is missing from the fresh data")
    length = max(round(INDEPENDENT_BLOCK_SCALES * effects.model.scale / step), 4)
    turned = float(np.std(stream(run, run.yaw_rate)[1])) >= MIN_TURN_SHARE * float(np.std(before[YAW_RATE][1]))
    change = change_of_rms(plain, better, length)
    torque_without, torque_with = (
        _torque_error(streams, fresh, signals, model, freed_of)
        for model, freed_of in ((plain_model, without), (better_model, effects))
    )
    scores = score(told.gains)
    against = [-scores]
    if not closed:
        against.append(-_free_scores(plain, better, max(round(FREE_RUN_BLOCK_SCALES * effects.model.scale / step), 1)))
    return Comparison(
        rms(plain),
        change.estimate,
        change.low,
        change.high,
        turned,
        torque_without,
        torque_with,
        evidence=evidence(scores),
        against=evidence(*against),
        won=final_log_wealth(scores),
    )


@dataclass(frozen=True, slots=True)
class _Forecasts:
    """Forecasts of the models without and with the effects, fitted to the data before.

    Attributes:
        gains: (blocks,) by how much log-likelihood the effects foretell the fresh data better.
        plain, better: the models.
    """

    gains: Array
    plain: TracedModel
    better: TracedModel


def _forecasts(streams: Streams, fresh: float, without: Compensation | None, effects: Compensation) -> _Forecasts:
    run, model = as_run(streams), effects.model
    wanted = {*effects.channels, *(() if without is None else without.channels)}
    names = [name for name in run.channels if name in wanted or name == HEADING_CHANNEL]
    problem = innovations.pose([run], model.inertia, names, COMMANDED_TORQUE, thinned=False)
    time = problem.cells.signals.time[problem.windows.first]
    before = time < fresh
    if before.sum() < MIN_CELLS_BEFORE:
        period = float(np.median(np.diff(time)))
        raise BadInput(
            f"{before.sum() * period:.3g} s of data are older than the fresh data, too few to learn the damping from: "
            f"{MIN_CELLS_BEFORE * period:.3g} s are needed"
        )
    plain = _fitted(problem, () if without is None else without.pairs(), before)
    better = _fitted(problem, effects.pairs(), before)
    gain = score_on(problem, better, ~before) - score_on(problem, plain, ~before)
    block = np.floor((time[~before] - fresh) / (BET_BLOCK_SCALES * model.scale)).astype(np.intp)
    gains = np.bincount(block, gain).astype(np.float64)
    return _Forecasts(gains, *(model_of(problem, each, model.sigma) for each in (plain, better)))


def _fitted(problem: Problem, pairs: Sequence[tuple[Effect, Term]], before: NDArray[np.bool_]) -> Fit:
    hypothesis: Hypothesis = problem.start
    for pair in pairs:
        hypothesis = hypothesis.with_part(Part(*pair, fixed=True))
    return fit(problem, hypothesis, problem.colour, use=before)


def _free_scores(plain: Sequence[Array], better: Sequence[Array], length: int) -> Array:
    """(blocks,) x of the free runs: by how much the effects err less in a block, over what both err."""
    without, with_them = (np.concatenate(errors) ** 2 for errors in (plain, better))
    block = np.arange(without.size) // length
    lost, left = np.bincount(block, without), np.bincount(block, with_them)
    return np.asarray((lost - left) / np.maximum(lost + left, 1e-300))


def as_run(streams: Streams) -> Run:
    """Streams as the tracer takes them: one column each on the instants of all, NaN where a stream has no value."""
    time = np.unique(np.concatenate([t for t, _ in streams.values()]))
    columns = {}
    for name, (t, values) in streams.items():
        columns[name] = np.full(time.size, np.nan)
        columns[name][np.searchsorted(time, t)] = values
    return Run("the recent data", time, columns.pop(YAW_RATE), columns.pop(TORQUE), columns)


def _with_learned_damping(
    model: TracedModel,
    streams: Streams,
    signals: SignalSettings,
    settings: learner.Settings,
    effects: Compensation | None,
    instead: TracedModel,
) -> TracedModel:
    """The model with the damping that a learner has after these streams, over the rates that it was trained at.

    Damping vanishes at rest: a constant moment that the learner took for it is taken out, and is no part of the model.
    Where the learner learned nothing, as while a heading is held, the damping is that of the forecasts, `instead`.
    """
    samples, _ = synchronise(signals, streams, takes_torque(signals, effects))
    state = learner.start(settings)
    # slow commands give few samples: less than a batch is one, if it holds as many as there may be vectors
    size = min(settings.batch, max(len(samples), settings.capacity))
    for first in range(0, len(samples) - size + 1, size):
        state, _ = learner.step(settings, state, samples.take(slice(first, first + size)))
    if state.model.trained_range is None:
        return replace(model, rate=instead.rate, damping=instead.damping)
    low, high = state.model.trained_range
    rate = np.unique(np.concatenate([np.linspace(min(low, -1e-6), 0.0, 101), np.linspace(0.0, max(high, 1e-6), 101)]))
    at_rest = state.model.predict(np.zeros(1)).damping
    return replace(model, rate=rate, damping=state.model.predict(rate).damping - at_rest)


def _torque_error(
    streams: Streams, fresh: float, signals: SignalSettings, model: TracedModel, effects: Compensation | None
) -> float:
    """The root mean square of what the model leaves of the torque in the fresh samples [N m]."""
    samples, _ = synchronise(signals, streams, takes_torque(signals, effects))
    samples = samples.take(samples.time >= fresh)
    return rms([samples.damping - np.interp(samples.yaw_rate, model.rate, model.damping)])


def _free_run(run: Run, model: TracedModel) -> tuple[list[Array], float]:
    """The errors of each stretch without a pause [rad/s], and the time between two of them [s]."""
    sampled = float(np.median(np.diff(stream(run, run.yaw_rate)[0])))
    step = max(model.scale / STEPS_PER_SCALE, sampled)
    signals = cut([run], model.inertia, list(run.channels), Cut(step, COMMANDED_TORQUE, model.scale)).signals
    index, simulated = model.simulate(signals)
    error, stretch = simulated - signals.rate[index], np.searchsorted(signals.start, index, side="right")
    return [error[stretch == k] for k in np.unique(stretch)], step
