"""Whether effects, as they were found, predict better on data that came after their trace.

Two models are fitted to the data before, one with the effects and one without, and both predict the fresh data; what
proves the effects is what proves them in `incsvr trace` (`incsvr.tracing.proof`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.proof import Proof
from incsvr.errors import BadInput
from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.identification import EFFECTS, PLAIN, plain_fit, structure_of
from incsvr.model.series import effort_of
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.tracing.proof import OUTPUT_ERROR, compared, held
from incsvr.tracing.recordings import Recordings, of_streams
from incsvr.tracing.unseen import judge

MIN_SAMPLES_BEFORE = 100
"""Samples of the yaw rate before the fresh data: below it no damping is determined."""
MIN_TURN_SHARE = 0.2
"""Part of how much it turned before by which a vehicle turns at least that tells anything of its effects."""


def compare_on_fresh_data(
    streams: Streams, fresh: float, without: Compensation | None, effects: Compensation, closed: bool = True
) -> Proof:
    """The errors of both models on what came from the time `fresh` [s] on, fitted to what came before.

    Args:
        streams: name → (stamps [s], values); yaw rate, torque and the channels that the effects read.
        fresh: where the fresh data begins [s].
        without: the effects that the model has anyway; None for none.
        effects: those to compare with.
        closed: a controller may have closed the loop: then a torque that answers the water makes any free run say
            nothing, and the predicted torque decides.

    Raises:
        BadInput: either side of `fresh` holds too little.
    """
    compensations = [effects] if without is None else [effects, without]
    before, after = (_recordings(part, compensations) for part in _parts(streams, fresh))
    axis, inertia = effects.model.axis, effects.model.inertia
    base = plain_fit(structure_of(before.streams, [axis], before.channels, {axis: inertia}), before.streams)
    plain = base if without is None else _with(base, before, without)
    free = plain.structure.plus(free=[axis])
    theta = {**plain.theta, f"mass:{axis}": plain.structure.given[axis]}
    fixed = () if without is None else without.model.theta
    models = {
        PLAIN: (plain, without),
        OUTPUT_ERROR: (fit(free, theta, plain.problem, plain.starts, fixed), without),
        EFFECTS: (_with(base, before, effects), effects),
    }
    judges = {
        name: judge(_acting(after, own), model, _acting(before, own), excluded=False)
        for name, (model, own) in models.items()
    }
    named = {name: judges[name].errors(model) for name, (model, _) in models.items()}
    changes = compared(named, EFFECTS, judges[EFFECTS], held(judges[EFFECTS], effects.model.whole_inertia))
    error = {"before": named[PLAIN].to_dict(), "after": named[EFFECTS].to_dict(), "change": changes.of(PLAIN)}
    itself = {EFFECTS} | ({OUTPUT_ERROR} if effects.names == ("inertia",) else set())
    rates = [np.concatenate([run[axis][1] for run in side.streams]) for side in (before, after)]
    turned = float(np.std(rates[1])) >= MIN_TURN_SHARE * float(np.std(rates[0]))
    return Proof(error, closed, changes.all_better(closed, itself), turned)


def _parts(streams: Streams, fresh: float) -> tuple[Streams, Streams]:
    """The streams before and from `fresh` [s] on."""
    early, late = dict[str, tuple[Array, Array]](), dict[str, tuple[Array, Array]]()
    for name, (t, values) in streams.items():
        early[name], late[name] = (t[t < fresh], values[t < fresh]), (t[t >= fresh], values[t >= fresh])
    return early, late


def _recordings(streams: Streams, compensations: list[Compensation]) -> Recordings:
    """One side of the data, with the names of the engine.

    Raises:
        BadInput: it holds too little.
    """
    names = {name: stream for each in compensations for name, stream in each.streams.items() if stream != YAW_RATE}
    time = streams[YAW_RATE][0]
    if time.size < MIN_SAMPLES_BEFORE or streams[TORQUE][0].size < 2:
        needed = MIN_SAMPLES_BEFORE * float(np.median(np.diff(time))) if time.size > 1 else np.nan
        raise BadInput(
            f"{np.ptp(time) if time.size else 0.0:.3g} s of data are on one side of the trace's end, too few to learn "
            f"the damping from: {needed:.3g} s are needed"
        )
    if any(streams[stream][0].size < 2 for stream in names.values()):
        raise BadInput("a channel that the effects read is missing from the fresh data")
    axis = compensations[0].model.axis
    own = {axis: streams[YAW_RATE], effort_of(axis): streams[TORQUE]}
    return of_streams(axis, [own | {name: streams[stream] for name, stream in names.items()}], list(names))


def _with(base: Fit, recordings: Recordings, effects: Compensation) -> Fit:
    """The plain model with effects as they are, fitted anew."""
    windows, model = base.problem.windows, effects.model
    structure = model.added_to(base.structure)
    again = cut(_acting(recordings, effects).streams, structure, windows.step, windows.step * windows.steps)
    return fit(structure, {**base.theta, **model.theta}, Problem(again), fixed=model.theta)


def _acting(recordings: Recordings, effects: Compensation | None) -> Recordings:
    """The recordings with the efforts that the effects let act."""
    if effects is None:
        return recordings
    effort = effort_of(recordings.axis)
    return replace(
        recordings, streams=tuple({**run, effort: effects.model.acting(run[effort])} for run in recordings.streams)
    )
