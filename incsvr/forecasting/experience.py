"""The errors of earlier forecasts, from which intervals follow.

    experience = experience.after(model, inertia, grid)    # before what is in the grid's newest part is learned

The newest part of the streams, before it is learned, is forecast from instants up to the longest horizon before it,
with the model that was served at each; what the errors are of the deviations that `propagation` claims is kept, horizon
by horizon. The interval of a forecast is as wide as 95 % of the latest of them were (split conformal prediction with
scores scaled by the claim): whatever the model does not know, thrust that lags, water that lasts, an inertia that is
off, is in it, as long as the vehicle goes on as it did.

Source: J. Lei et al., Distribution-free predictive inference for regression, JASA 113, 2018, Section 5.2 (locally
weighted conformal inference).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import Compensation
from incsvr.forecasting.grid import Grid
from incsvr.forecasting.propagation import free_runs
from incsvr.learning.model import Model
from incsvr.numerics import Array

HORIZONS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0)
"""Times ahead at which errors are kept [s]."""
HORIZON_ERRORS = 100
"""Errors of a horizon: of the last twenty batches. What the model did not know when it was young must not widen the
intervals for long."""
MAX_BATCH_ERRORS = 5
"""Errors that a batch adds to a horizon at most: those close to each other tell the same."""
MIN_INDEPENDENT_ERRORS = 19
"""Independent errors from which on the 95 % of them are one of them; below, their spread and Student's t must do."""
MAX_MODELS = 4
"""Models that were served are kept, so that a start is forecast with no later one than was served then."""
UNTRIED_WIDENING = 2.0
"""Factor by which an interval is wider than claimed where no forecast was tried yet."""
NORMAL_95_DEVIATIONS = 1.96
"""Half an interval of 95 %, in standard deviations."""
START_SIGMA_SHARE = 0.01
"""Part of the fastest rate to which a rate that starts a forecast is known: filter, mounting and scale of a gyro."""
USUAL_RATES_S = 900.0
"""Time for which a rate counts for what is usual [s]: as long as a sample counts as fresh in health."""


@dataclass(frozen=True, slots=True)
class Experience:
    """The errors of earlier forecasts; bounded, and without a clock or chance.

    Attributes:
        models: those that were served, the oldest first, each with the time since which it was [s].
        scores: for each horizon, of the latest forecasts, (k, 3): when the batch in which it ended did [s], and the
            errors of rate and heading in claimed deviations.
        fastest: the fastest rate so far [rad/s].
        square: mean square of the rates of the last USUAL_RATES_S [rad²/s²].
        until: what ends later is new [s].
    """

    models: tuple[tuple[float, Model], ...] = ()
    scores: tuple[Array, ...] = tuple(np.empty((0, 3)) for _ in HORIZONS_S)
    fastest: float = 0.0
    square: float = 0.0
    until: float = -math.inf

    def after(self, model: Model, inertia: float, grid: Grid, effects: Compensation | None = None) -> Experience:
        """The experience with a grid that is not learned yet; `model` is served, trained or not.

        Args:
            inertia: as it is declared [kg m²].
            grid: the streams as far back as the longest horizon.
            effects: traced effects in force, with which the models were learned.
        """
        if not grid.time.size:
            return self
        if grid.time[-1] < self.until:  # the vehicle's clock restarted
            return replace(self, models=(), until=-math.inf).after(model, inertia, grid, effects)
        new = grid.time > self.until
        rates = grid.rate[new][np.isfinite(grid.rate[new])]
        models = self.models
        if model.is_trained and (not models or models[-1][1] is not model):
            models = _thinned((*models, (max(self.until, float(grid.time[0])), model)))
        kept = replace(self, models=models)
        if rates.size:
            stays = math.exp(-rates.size * grid.step / USUAL_RATES_S) if self.fastest else 0.0
            kept = replace(
                kept,
                fastest=max(self.fastest, float(np.abs(rates).max())),
                square=stays * self.square + (1.0 - stays) * float(np.mean(rates**2)),
            )
        if kept.models and kept.fastest > 0.0:
            kept = kept._tried(inertia, grid, effects)
        return replace(kept, until=float(grid.time[-1]))

    def under_other_effects(self) -> Experience:
        """The experience under other effects: the errors of forecasts are collected again, with the models."""
        return Experience(fastest=self.fastest, square=self.square, until=self.until)

    @property
    def usual(self) -> float:
        """Half the width of what the rates are usually within, about rest [rad/s]."""
        return NORMAL_95_DEVIATIONS * math.sqrt(self.square)

    @property
    def start_sigma(self) -> float:
        """The standard deviation of the rate at a start [rad/s]."""
        return START_SIGMA_SHARE * self.fastest

    def widening(self, ahead: Array) -> tuple[Array, Array]:
        """The factors of the intervals of rate and heading over the model's own, so far ahead (n,) [s]."""
        known = [
            (math.log(horizon), *widening(scores, horizon))
            for horizon, scores in zip(HORIZONS_S, self.scores, strict=True)
            if len(scores)
        ]
        if not known:
            return np.full(ahead.size, UNTRIED_WIDENING), np.full(ahead.size, UNTRIED_WIDENING)
        places, *scales = (np.array(column) for column in zip(*known, strict=True))
        at = np.log(np.maximum(ahead, HORIZONS_S[0]))
        # Further than anything was tried it is no better than the worst of what was.
        beyond = at > places[-1] + 1e-9
        rate, heading = (np.where(beyond, scale.max(), np.interp(at, places, scale)) for scale in scales)
        return rate, heading

    def to_dict(self) -> dict[str, Any]:
        """Plain data: after a restart the scores count on, and the models come anew."""
        return {
            "scores": [scores.tolist() for scores in self.scores],
            "fastest": self.fastest,
            "square": self.square,
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Experience:
        """Raises an exception of any kind where it is not what `to_dict` can have given."""
        scores = tuple(np.array(each, dtype=np.float64).reshape(-1, 3)[-HORIZON_ERRORS:] for each in data["scores"])
        fastest, square = float(data["fastest"]), float(data["square"])
        if len(scores) != len(HORIZONS_S) or not all(np.isfinite(each).all() for each in scores):
            raise ValueError("these are no scores of forecasts")
        if not (math.isfinite(fastest) and fastest >= 0.0 and math.isfinite(square) and square >= 0.0):
            raise ValueError("these are no rates")
        return Experience(scores=scores, fastest=fastest, square=square)

    def _tried(self, inertia: float, grid: Grid, effects: Compensation | None) -> Experience:
        """The experience with the errors of forecasts that end in the new part."""
        scores = list(self.scores)
        for part in grid.stretches():
            for which, found in self._stretch(inertia, grid.part(part), float(grid.time[-1]), effects):
                scores[which] = np.concatenate((scores[which], found))[-HORIZON_ERRORS:]
        return replace(self, scores=tuple(scores))

    def _stretch(
        self, inertia: float, grid: Grid, batch_end: float, effects: Compensation | None
    ) -> Iterator[tuple[int, Array]]:
        """The errors of each horizon over a grid without a pause, whose batch ended at `batch_end` [s]."""
        time, measured, step = grid.time, grid.rate, grid.step
        turned = np.concatenate(([0.0], np.cumsum(0.5 * step * (measured[1:] + measured[:-1]))))
        lengths = [round(horizon / step) for horizon in HORIZONS_S]
        ends_from = int(np.searchsorted(time, self.until, side="right"))
        starts = [_starts(time.size, length, ends_from) for length in lengths]
        for model, own in self._by_model(time):
            mine = np.unique(np.concatenate([each[own[each]] for each in starts]))
            if not mine.size:
                continue
            longest = max(length for length, each in zip(lengths, starts, strict=True) if own[each].any())
            start = measured[mine], self.start_sigma
            runs = free_runs(model, inertia, self.fastest, grid, mine, longest, *start, effects)
            for which, (length, each) in enumerate(zip(lengths, starts, strict=True)):
                column = np.searchsorted(mine, each[own[each]])
                if column.size:
                    end = mine[column] + length
                    off = np.abs(runs.rate[length, column] - measured[end]) / runs.rate_sigma[length, column]
                    away = np.abs(runs.heading[length, column] - (turned[end] - turned[mine[column]]))
                    claimed = runs.heading_sigma[length, column]
                    yield which, np.column_stack((np.full(end.size, batch_end), off, away / claimed))

    def _by_model(self, at: Array) -> Iterator[tuple[Model, NDArray[np.bool_]]]:
        """Each model with the instants (n,) at which it was the one to forecast with."""
        since = np.array([begin for begin, _ in self.models])
        newest = np.searchsorted(since, at, side="right") - 1
        for place, (_, model) in enumerate(self.models):
            yield model, newest == place


def widening(scores: Array, horizon: float) -> tuple[float, float]:
    """The width of 95 % of some forecasts' errors, of rate and heading, in claimed intervals.

    Args:
        scores: (k, 3), k ≥ 1, as in `Experience`.
        horizon: [s]; forecasts that overlap tell the same twice, and so do those of one batch, which are off by the
            same that the model did not know.
    """
    errors, ended = scores[:, 1:], np.unique(scores[:, 0])
    independent = min(ended.size, 1.0 + float(np.ptp(ended)) / horizon)
    rank = min(math.ceil(0.95 * (len(scores) + 1)), len(scores)) - 1
    found = np.sort(errors, axis=0)[rank]
    if independent < MIN_INDEPENDENT_ERRORS:
        # Here and not above: 25 MB that a learner whose rate is never silent does not need.
        from scipy.special import stdtrit

        found = np.maximum(found, np.sqrt(np.mean(errors**2, axis=0)) * float(stdtrit(independent, 0.975)))
    return float(found[0]) / NORMAL_95_DEVIATIONS, float(found[1]) / NORMAL_95_DEVIATIONS


def _thinned(models: tuple[tuple[float, Model], ...]) -> tuple[tuple[float, Model], ...]:
    """The models that are furthest apart, at most MAX_MODELS; the newest is kept."""
    while len(models) > MAX_MODELS:
        apart = [models[k + 1][0] - models[k - 1][0] for k in range(1, len(models) - 1)]
        drop = 1 + int(np.argmin(apart))
        models = models[:drop] + models[drop + 1 :]
    return models


def _starts(size: int, length: int, ends_from: int) -> NDArray[np.intp]:
    """The starts of forecasts of so many steps that end in the newest part, evenly spread."""
    first, last = max(ends_from - length, 0), size - 1 - length
    if length < 1 or last < first:
        return np.empty(0, dtype=np.intp)
    apart = max(length // 2, (last - first) // MAX_BATCH_ERRORS, 1)
    return np.arange(last, first - 1, -apart, dtype=np.intp)[::-1]
