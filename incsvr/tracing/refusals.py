"""The refusal of recordings that cannot answer, in one sentence with its cure."""

from __future__ import annotations

import math

import numpy as np

from incsvr.errors import BadInput
from incsvr.model.fitting import fit
from incsvr.model.identification import PLAIN, Identification
from incsvr.model.series import effort_of, noise, values
from incsvr.plant.axes import of_rate
from incsvr.plant.words import words_of
from incsvr.tracing.proof import OUTPUT_ERROR
from incsvr.tracing.recordings import Recordings


def refuse_too_little_motion(
    recordings: Recordings,
    scale: float,
    found: Identification | None = None,
    doubt: float = 0.5,  # the largest relative standard error of the thrust's gain
    turning: float = 7.0,  # the fastest turns (99 %) in deviations of the gyro's noise, at least
    turning_idle: float = 35.0,  # the same where the torque is next to nothing for most of the time
    idle_share: float = 0.85,  # of the time, beyond which it is
    nothing: float = 0.02,  # of the largest torque, below which one is next to nothing
) -> None:
    """Raises BadInput where the vehicle hardly moves, or its torque hardly moves it: there anything explains
    everything.

    Args:
        scale: of the motion [s].
        found: with it the inertia's uncertainty is judged, too.
    """
    axis, runs = recordings.axis, recordings.streams
    torque = values(runs, effort_of(axis))
    if float(np.ptp(torque)) == 0.0:
        return  # what turns a vehicle whose thrusters stand still is another question
    fastest = float(np.quantile(np.abs(values(runs, axis)), 0.99))
    scatter = max(noise(run[axis][1]) for run in runs)
    unsure = 0.0 if found is None else _inertia_error(found, axis)
    idle = float(np.mean(np.abs(torque) < nothing * float(np.max(np.abs(torque)))))
    least = turning_idle if idle > idle_share else turning
    if unsure > doubt or fastest < least * scatter:
        words = words_of(of_rate(axis))
        unsaid = f", and its effect would leave the {words.inertia} uncertain by {min(unsure, 9.99):.0%}"
        raise BadInput(
            f"too little motion: 99 % of the {words.rates} are below {fastest:.2g} {words.rate_unit} with a gyro noise "
            f"of {scatter:.1g}, the {words.effort} is near zero for {idle:.0%} of the time{unsaid if unsure else ''}; "
            f"drive turns both ways with steps of a quarter, half and all of the {words.effort}, each held for "
            f"{max(2.0 * scale, 5.0):.0f} s, for ten minutes"
        )


def _inertia_error(found: Identification, axis: str) -> float:
    """Relative standard error of a free inertia, which is that of the thrust's gain, by independent errors: of the
    simulator, or of the predictor, whose errors are less where the water is rough."""
    predictor = found.found.fit
    free = predictor.structure.plus(free=[axis])
    theta = {f"mass:{axis}": found.models[PLAIN].structure.given[axis], **predictor.theta}
    errors = []
    for each in (found.models[OUTPUT_ERROR], fit(free, theta, predictor.problem, predictor.starts, rounds=0)):
        place = each.names.index(f"mass:{axis}")
        inverse = np.linalg.pinv(each.normal.sum(axis=0) + np.diag(each.prior), rcond=1e-12)
        errors.append(float(each.units[place]) * math.sqrt(max(float(inverse[place, place]), 0.0)))
    return min(errors)
