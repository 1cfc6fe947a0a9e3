"""A forecast: where the yaw rate and the heading go from a start under a torque that is known, and within what."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.forecasting.experience import NORMAL_95_DEVIATIONS, Experience
from incsvr.forecasting.propagation import Curve, propagate
from incsvr.learning.model import Model
from incsvr.numerics import Array

MAX_FORECAST_S = 3600.0
"""Longest forecast [s]."""
MAX_FORECAST_STEPS = 20_000
"""Steps of a forecast at most."""


@dataclass(frozen=True, slots=True)
class Start:
    """The last that was measured: its time [s], and the yaw rate then [rad/s]."""

    time: float
    rate: float


@dataclass(frozen=True, slots=True)
class Forecast:
    """At (n,) times, with intervals of 95 %.

    Attributes:
        time: (n,) [s].
        rate, rate_half: (n,) yaw rate, and half its interval [rad/s].
        turned, turned_half: (n,) the heading's change since the start, and half its interval [rad].
        worth: (n,) whether the interval of the rate is narrower than what the vehicle's own rates are usually within:
            else whoever knows nothing but those knows as much.
    """

    time: Array
    rate: Array
    rate_half: Array
    turned: Array
    turned_half: Array
    worth: NDArray[np.bool_]


def forecast(
    experience: Experience,
    model: Model,
    inertia: float,
    start: Start,
    torque: tuple[Array, Array],
    at: Array,
    *,
    step: float,
    sample_period: float,
) -> Forecast:
    """From a start to the times `at` (n,) [s], increasing, none before it.

    Args:
        torque: stamps (m,) [s], increasing, and values (m,) [N m]: linear between them, held before and after.
        step: of the integration [s], that of the `Grid` which the experience is of.
        sample_period: between two samples of the learner [s].

    Raises:
        BadInput: nothing was learned, or the times are none that can be reached.
    """
    if not model.is_trained or experience.fastest <= 0.0:
        raise BadInput("nothing was learned yet; ask again after the first iteration")
    if not at.size or not torque[0].size or not (np.diff(at) >= 0.0).all() or not at[0] >= start.time:
        raise BadInput("a forecast needs times that increase from its start on, and a torque")
    ahead = float(at[-1]) - start.time
    if not ahead <= MAX_FORECAST_S:
        raise BadInput(f"a forecast over {ahead:.6g} s is longer than {MAX_FORECAST_S:g} s")
    step = max(step, ahead / MAX_FORECAST_STEPS)
    count = max(math.ceil(ahead / step), 1)
    even = start.time + step * np.arange(count + 1)
    curve = Curve.of(model, inertia, max(experience.fastest, abs(start.rate)), sample_period)
    moment = np.interp(even, *torque)[:, None]
    runs = propagate(curve, np.array([start.rate]), experience.start_sigma, moment, step)
    rate, turned, rate_sigma, turned_sigma = (
        np.interp(at, even, values[:, 0]) for values in (runs.rate, runs.heading, runs.rate_sigma, runs.heading_sigma)
    )
    wider, turns_wider = experience.widening(at - start.time)
    half = NORMAL_95_DEVIATIONS * wider * rate_sigma
    return Forecast(at, rate, half, turned, NORMAL_95_DEVIATIONS * turns_wider * turned_sigma, half < experience.usual)
