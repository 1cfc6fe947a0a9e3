"""Whether effects predict better on data that nobody has looked at: the proof of `incsvr trace --validate`, for effects
as they were found.

Two models are fitted to the data before, one with the effects and one without, and both predict the fresh data.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, Compensation
from incsvr.compensation.proof import Proof
from incsvr.effects import Effect, Term
from incsvr.errors import BadInput
from incsvr.model_trace.held_out import is_proven
from incsvr.model_trace.run import Run
from incsvr.model_trace.torque_nature import TorqueNature
from incsvr.numerics import Array, Streams
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.tracing.cells import cut
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, fit
from incsvr.tracing.hypothesis import Hypothesis, Part
from incsvr.tracing.trace import problem_of
from incsvr.tracing.validation import validate

MIN_CELLS_BEFORE = 100
"""Cells before the fresh data, ten for each coefficient of damping and noise: below it nothing is determined."""
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
    before, after = (as_run(part) for part in _parts(streams, fresh))
    wanted = {*effects.channels, *(() if without is None else without.channels)}
    names = [name for name in before.channels if name in wanted or name == HEADING_CHANNEL]
    nature = TorqueNature(held=True, noisy=False, closed=closed)
    inertia = effects.model.inertia
    problem, how = problem_of([before], inertia, names, nature)
    cells = problem.cells
    if len(cells) < MIN_CELLS_BEFORE:
        raise BadInput(
            f"{len(cells) * cells.step:.3g} s of data are older than the fresh data, too few to learn the damping "
            f"from: {MIN_CELLS_BEFORE * cells.step:.3g} s are needed"
        )
    plain = _fitted(problem, () if without is None else without.pairs())
    better = _fitted(problem, effects.pairs())
    error = validate(problem, plain, better, cut([after], inertia, names, how)).to_dict(effects.model.sigma)
    if not all(np.isfinite(error[when]["free_run_rmse"]) for when in ("before", "after")):
        raise BadInput("a channel that the effects read is missing from the fresh data")
    turned = float(np.nanstd(after.yaw_rate)) >= MIN_TURN_SHARE * float(np.nanstd(before.yaw_rate))
    return Proof(
        {name: error[name] for name in ("before", "after", "change")}, closed, is_proven(error, closed), turned
    )


def as_run(streams: Streams) -> Run:
    """Streams as the tracer takes them: one column each on the instants of all, NaN where a stream has no value."""
    time = np.unique(np.concatenate([t for t, _ in streams.values()]))
    columns = {}
    for name, (t, values) in streams.items():
        columns[name] = np.full(time.size, np.nan)
        columns[name][np.searchsorted(time, t)] = values
    return Run("the recent data", time, columns.pop(YAW_RATE), columns.pop(TORQUE), columns)


def _parts(streams: Streams, fresh: float) -> tuple[Streams, Streams]:
    """The streams before and from `fresh` [s] on."""
    early, late = dict[str, tuple[Array, Array]](), dict[str, tuple[Array, Array]]()
    for name, (t, values) in streams.items():
        early[name], late[name] = (t[t < fresh], values[t < fresh]), (t[t >= fresh], values[t >= fresh])
    return early, late


def _fitted(problem: Problem, pairs: Sequence[tuple[Effect, Term]]) -> Fit:
    hypothesis: Hypothesis = problem.start
    for pair in pairs:
        hypothesis = hypothesis.with_part(Part(*pair, fixed=True))
    return fit(problem, hypothesis, problem.colour)
