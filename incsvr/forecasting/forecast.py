"""A forecast: where the yaw rate and the heading go from a start under a torque that is known, and within what."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import Compensation
from incsvr.errors import BadInput
from incsvr.forecasting.experience import NORMAL_95_DEVIATIONS, Experience
from incsvr.forecasting.grid import Grid
from incsvr.forecasting.other_influences import OtherInfluences
from incsvr.forecasting.propagation import free_runs
from incsvr.learning.model import Model
from incsvr.numerics import Array, Streams
from incsvr.plant.body import Coupled

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
class Surroundings:
    """The influences on the axis beside its own torque, which a forecast continues.

    Attributes:
        past: a grid without a pause that ends where the forecast starts, from which effects remember.
        streams: name → (stamps [s], values) of the channels `names` and of those of the body, as far as they came:
            beyond the last value of one it stays.
        names: of the channels that the model or the effects look at.
        body: the axis in its body; None takes it by itself.
        smoothing: width of the learner's filter [s].
        effects: traced effects in force; None for none.
    """

    past: Grid
    streams: Streams
    names: tuple[str, ...] = ()
    body: Coupled | None = None
    smoothing: float = 1.0
    effects: Compensation | None = None

    def ahead(self, even: Array, moment: Array, start: Start) -> Grid:
        """The past, then the times (n,) [s] of a forecast with the torque (n,) there, as one grid of even steps."""
        past, step = self.past, float(even[1] - even[0])
        count = int((even[0] - past.time[0]) / step) if past.time.size else 0
        before = even[0] - step * np.arange(count, 0, -1)
        time = np.concatenate((before, even))
        rate, torque = (
            np.concatenate((np.interp(before, past.time, known) if count else before, new))
            for known, new in ((past.rate, np.full(even.size, start.rate)), (past.torque, moment))
        )
        beside = OtherInfluences.at(time, self.streams, self.names, self.body, self.smoothing)
        return Grid(time, step, rate, torque, past.sample_period, beside)


@dataclass(frozen=True, slots=True)
class Forecast:
    """The forecast at (n,) times, with intervals of 95 %.

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
    surroundings: Surroundings | None = None,
) -> Forecast:
    """The forecast from a start to the times `at` (n,) [s], increasing, none before it.

    Args:
        torque: stamps (m,) [s], increasing, and values (m,) [N m]: linear between them, held before and after.
        step: of the integration [s], that of the `Grid` which the experience is of.
        sample_period: between two samples of the learner [s].
        surroundings: what else moves the axis; None where nothing does.

    Raises:
        BadInput: nothing was learned, or the times are none that can be reached.
    """
    if not model.is_trained or experience.fastest <= 0.0:
        raise BadInput("nothing was learned yet; ask again after the first iteration")
    if not at.size or not torque[0].size or not (np.diff(at) >= 0.0).all() or not at[0] >= start.time:
        raise BadInput("a forecast needs times that increase from its start on, and the effort then")
    ahead = float(at[-1]) - start.time
    if not ahead <= MAX_FORECAST_S:
        raise BadInput(f"a forecast over {ahead:.6g} s is longer than {MAX_FORECAST_S:g} s")
    step = max(step, ahead / MAX_FORECAST_STEPS)
    count = max(math.ceil(ahead / step), 1)
    even: Array = start.time + step * np.arange(count + 1, dtype=np.float64)
    moment, effects = np.interp(even, *torque), None
    grid = Grid(even, step, np.full(even.size, start.rate), moment, sample_period)
    if surroundings is not None:
        grid = surroundings.ahead(even, moment, start)
        effects = surroundings.effects
    first, rate = np.array([grid.time.size - even.size]), np.array([start.rate])
    fastest = max(experience.fastest, abs(start.rate))
    runs = free_runs(model, inertia, fastest, grid, first, count, rate, experience.start_sigma, effects)
    rate, turned, rate_sigma, turned_sigma = (
        np.interp(at, even, values[:, 0]) for values in (runs.rate, runs.heading, runs.rate_sigma, runs.heading_sigma)
    )
    wider, turns_wider = experience.widening(at - start.time)
    half = NORMAL_95_DEVIATIONS * wider * rate_sigma
    return Forecast(at, rate, half, turned, NORMAL_95_DEVIATIONS * turns_wider * turned_sigma, half < experience.usual)
