"""The refusals of recordings that cannot answer, one sentence each with its cure."""

from __future__ import annotations

import numpy as np

from incsvr.errors import BadInput
from incsvr.model_trace.thresholds import (
    IDLE_TORQUE_SHARE,
    MAX_GAIN_ERROR,
    MAX_IDLE_SHARE,
    MIN_IDLE_TURN_DEVIATIONS,
    MIN_TURN_DEVIATIONS,
)
from incsvr.signals.scales import white_noise
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, precision
from incsvr.tracing.hypothesis import starts
from incsvr.tracing.search import Search


def refuse_too_little_motion(search: Search) -> None:
    """Raises BadInput where the vehicle hardly moves, or its torque hardly moves it: there anything explains
    everything."""
    problem, nothing = search.problem, search.tried(search.problem.start).fitted
    s = problem.cells.signals
    if float(np.ptp(s.torque)) == 0.0:
        return  # what turns a vehicle whose thrusters stand still is another question
    fastest = float(np.quantile(np.abs(s.rate), 0.99))
    scatter = white_noise(np.diff(s.rate, 3))
    unsure = _gain_error(problem, nothing)
    inertia = next((effect for effect in search.effects if effect.acts == "inertia"), None)
    if unsure > MAX_GAIN_ERROR and inertia is not None:  # a wrong inertia leaves errors that are no lack of motion
        wider = problem.start.with_part(next(starts(inertia, s)))
        unsure = _gain_error(problem, search.tried(wider).fitted)
    idle = float(np.mean(np.abs(s.torque) < IDLE_TORQUE_SHARE * max(float(np.max(np.abs(s.torque))), 1e-300)))
    least = MIN_IDLE_TURN_DEVIATIONS if idle > MAX_IDLE_SHARE else MIN_TURN_DEVIATIONS
    if unsure > MAX_GAIN_ERROR or fastest < least * scatter:
        words = s.words
        raise BadInput(
            f"too little motion: 99 % of the {words.rates} are below {fastest:.2g} {words.rate_unit} with a gyro noise "
            f"of {scatter:.1g}, the {words.effort} is near zero for {idle:.0%} of the time, and its effect would leave "
            f"the {words.inertia} uncertain by {min(unsure, 9.99):.0%}; drive turns both ways with steps of a quarter, "
            f"half and all of the {words.effort}, each held for {max(2.0 * s.scale, 5.0):.0f} s, for ten minutes"
        )


def _gain_error(problem: Problem, nothing: Fit) -> float:
    """Relative standard error of the thrust's gain beside a free damping."""
    response, root = nothing.response, np.sqrt(nothing.weight)
    d = response.dynamics
    pushes = (d.thrust[response.cell] / d.inertia).reshape(1, *response.shape)
    column = (nothing.colour.whiten(problem.looked_at(response.of(pushes))) * root).ravel()
    base = (nothing.jacobian * root).reshape(nothing.jacobian.shape[0], -1)
    information = base @ base.T + precision(problem, nothing.hypothesis, nothing.colour) * nothing.variance
    beside = base @ column
    left = float(column @ column - beside @ np.linalg.lstsq(information, beside)[0])
    return float(np.sqrt(nothing.variance / max(left, 1e-300)))
