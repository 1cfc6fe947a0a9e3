"""The model in the gyro's place: forecasts from the last that was measured, and how right earlier ones were.

Of one learner. It looks at the newest raw data, and before a batch is learned tries its own forecasts on them
(`incsvr.forecasting.Experience`). One thread learns; anybody asks.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.forecasting import Experience, Forecast, Grid, Start, Surroundings, forecast
from incsvr.forecasting.experience import HORIZONS_S
from incsvr.learning.model import Model
from incsvr.numerics import Array, Stream
from incsvr.plant.body import Coupled
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED
from incsvr.signals.steps import refuse_steps
from incsvr.signals.streams import JUMP_S
from service import wire
from service.learner.published import check_trained
from service.learner.questions import refuse_effort
from service.learner.raw_streams import RawStreams

if TYPE_CHECKING:
    from incsvr.compensation.effects_in_force import Compensation
    from service.learner.node import LearnerNode


log = logging.getLogger(__name__)

MEMORY_S = 300.0
"""The time for which raw data count [s]: an estimate goes on from what was measured no longer ago."""
TRIAL_PERIOD_S = 20.0
"""The time between two trials of forecasts [s]: in quick batches they would cost more than the learning."""


@dataclass(frozen=True, slots=True)
class ForecastFromStart:
    """A forecast, the start that it is from, and the newest torque that it knows of [s]."""

    start: Start
    forecast: Forecast
    newest: float

    @property
    def columns(self) -> dict[str, Any]:
        """Times, rates and headings with their intervals of 95 %, and what they are worth, as payloads name them."""
        found = self.forecast
        columns = {
            "t": found.time,
            "rate": found.rate,
            "rate_low": found.rate - found.rate_half,
            "rate_high": found.rate + found.rate_half,
            "turned": found.turned,
            "turned_low": found.turned - found.turned_half,
            "turned_high": found.turned + found.turned_half,
            "worth": found.worth,
        }
        return {name: tuple(values.tolist()) for name, values in columns.items()}


class StandIn:
    """The stand-in of a learner with these signals.

    Args:
        signals: how streams become samples.
        raw: their newest data.
        memory: what an earlier `to_dict` gave.
        others: the channels of the further velocities that damping is learned over.
        coupled: the axis in its body; None takes it by itself.
        effects: the traced effects in force.
        words: of the axis.
    """

    def __init__(
        self,
        signals: SignalSettings,
        raw: RawStreams,
        memory: Mapping[str, Any] | None = None,
        others: tuple[str, ...] = (),
        coupled: Coupled | None = None,
        effects: Compensation | None = None,
        words: AxisWords = YAW_WORDS,
    ) -> None:
        self._signals, self._raw = signals, raw
        self._others, self._coupled, self._effects, self._words = others, coupled, effects, words
        self._believed_ends: deque[float] = deque(maxlen=3)
        self._pending_trial: tuple[Model, float, float, float] | None = None
        try:
            self.experience = Experience() if memory is None else Experience.from_dict(memory)
        except Exception:  # what earlier forecasts taught comes again: nothing else is lost
            self.experience = Experience()

    def batch_learned(self, model: Model, batch: Samples, smoothing: float) -> None:
        """A batch was believed and learned; `model` was served until then. Forecasts on it are tried by `catch_up`."""
        end = float(batch.time[-1])
        self._believed_ends.append(end)
        since = self.experience.until
        if not since <= end < since + TRIAL_PERIOD_S:
            self._pending_trial = model, min(max(since, end - MEMORY_S), float(batch.time[0])), end, smoothing

    def catch_up(self) -> None:
        """Tries forecasts on what was learned since the last time: after it was published, because it takes a while."""
        if self._pending_trial is None:
            return
        (model, begin, end, smoothing), self._pending_trial = self._pending_trial, None
        try:
            grid = self._grid(begin - HORIZONS_S[-1], end, smoothing)
            if (names := self._names()) or self._coupled is not None:
                grid = grid.among(self._channels(), names, self._coupled, smoothing)
            self.experience = self.experience.after(model, self._signals.inertia, grid, self._effects)
        except Exception:  # whatever came, learning goes on; the intervals begin anew
            log.exception("a fault of this program: forecasts could not be tried")
            self.experience = Experience()

    def taken_back(self) -> None:
        """The batch that was learned last was not to be believed."""
        if self._believed_ends:
            self._believed_ends.pop()

    def change_effects(self, effects: Compensation | None) -> None:
        """Takes these effects as in force, with a model that was learned with them."""
        self._effects, self._pending_trial = effects, None
        self.experience = self.experience.under_other_effects()

    def since_measured(self, model: Model, smoothing: float, believed: bool) -> ForecastFromStart:
        """The forecast from the last measurement to the newest torque.

        Args:
            smoothing: width of the filter now [s].
            believed: whether the gyro is; else the last batch that was learned is the last measurement.

        Raises:
            BadInput: there is no measurement to begin with, or no model.
        """
        start, torque, newest, past = self._begin(smoothing, believed)
        ahead = max(newest - start.time, 0.0)
        at = start.time + np.linspace(0.0, ahead, 61 if ahead > 0.0 else 1)
        return self._ahead(model, smoothing, start, torque, at, newest, past)

    def under(
        self, model: Model, smoothing: float, believed: bool, t: Array, torque: Array, at: Array
    ) -> ForecastFromStart:
        """The forecast from the last measurement on under a planned torque: times (n,) from then on [s], and [N m]."""
        start, _, newest, past = self._begin(smoothing, believed)
        profile = start.time + t, torque
        return self._ahead(model, smoothing, start, profile, start.time + at, newest, past)

    def newest_value(self, channel: str) -> float | None:
        """The newest value of a channel; None where none came within JUMP_S of the newest torque."""
        (stamps, values), torque = self._stream(channel), self._stream(TORQUE)[0]
        if not stamps.size or (torque.size and torque[-1] - stamps[-1] > JUMP_S):
            return None
        return float(values[-1])

    def to_dict(self) -> dict[str, Any]:
        return self.experience.to_dict()

    def _ahead(
        self, model: Model, smoothing: float, start: Start, torque: Stream, at: Array, newest: float, past: Grid
    ) -> ForecastFromStart:
        found = forecast(
            self.experience, model, self._signals.inertia, start, torque, at, step=past.step,
            sample_period=past.sample_period, surroundings=self._surroundings(past, smoothing, newest),
        )  # fmt: skip
        return ForecastFromStart(start, found, newest)

    def _surroundings(self, past: Grid, smoothing: float, newest: float) -> Surroundings | None:
        """The other influences on the axis; None if there are none."""
        names, body = self._names(), self._coupled
        if not names and body is None and self._effects is None:
            return None
        streams = self._channels()
        for name, (stamps, _) in streams.items():
            if not stamps.size or newest - stamps[-1] > JUMP_S:
                raise BadInput(
                    f"a forecast needs {name}, and none has arrived for more than {JUMP_S:g} s; ask again when it "
                    "arrives"
                )
        return Surroundings(past, streams, names, body, smoothing, self._effects)

    def _names(self) -> tuple[str, ...]:
        """The channels that the model or the effects look at."""
        read = () if self._effects is None else self._effects.reads(self._signals.channels)
        return tuple(dict.fromkeys((*self._others, *read)))

    def _channels(self) -> dict[str, Stream]:
        """The channels that a forecast needs, with those of the body."""
        body = () if self._coupled is None else self._coupled.streams
        return {name: self._stream(name) for name in (*self._names(), *body)}

    def _begin(self, smoothing: float, believed: bool) -> tuple[Start, Stream, float, Grid]:
        """The start of an estimate, the torque from there on with its newest stamp, and the streams until the start."""
        until = math.inf
        if not believed:
            if not self._believed_ends:
                raise BadInput("there is no valid measurement yet; ask again after the first iteration")
            until = self._believed_ends[-1]
        rate_word, effort_word = self._words.rate, self._words.effort
        rate, torque = self._stream(YAW_RATE), self._stream(TORQUE)
        if not rate[0].size or not torque[0].size:
            raise BadInput(f"no {rate_word} or no {effort_word} has arrived since the start; ask again when both have")
        newest = float(torque[0][-1])
        grid = self._grid(newest - MEMORY_S, min(until, float(rate[0][-1])), smoothing)
        known = np.flatnonzero(np.isfinite(grid.rate))
        if not known.size:
            raise BadInput(f"the last valid {rate_word} is older than {MEMORY_S:g} s, or no {effort_word} came with it")
        place = int(known[-1])
        start = Start(float(grid.time[place]), float(grid.rate[place]))
        unknown = np.flatnonzero(~np.isfinite(grid.rate[: place + 1] + grid.torque[: place + 1]))
        past = grid.part(slice(int(unknown[-1]) + 1 if unknown.size else 0, place + 1))
        since = torque[0] >= start.time - 2.0 * grid.step
        if self._signals.torque == COMMANDED:  # it holds: said by a second stamp just before the next
            stamps, values = torque[0][since], torque[1][since]
            edges = np.maximum(np.nextafter(stamps[1:], -np.inf), stamps[:-1])
            together = np.concatenate((stamps, edges)), np.concatenate((values, values[:-1]))
            order = np.argsort(together[0], kind="stable")
            return start, (together[0][order], together[1][order]), newest, past
        return start, (torque[0][since], torque[1][since]), newest, past

    def _grid(self, begin: float, end: float, smoothing: float) -> Grid:
        parts = []
        for stream in (YAW_RATE, TORQUE):
            time, value = self._stream(stream)
            inside = (time >= begin) & ((time <= end) | (stream == TORQUE))
            parts.append((time[inside], value[inside]))
        held = self._signals.torque == COMMANDED
        return Grid.of(parts[0], parts[1], smoothing, self._signals.sample_period, held)

    def _stream(self, stream: str) -> Stream:
        """The recent measurements of a stream."""
        return self._raw.read(stream, MEMORY_S)


def forecast_reply(node: LearnerNode, asked: wire.ForecastQuery | None) -> wire.ForecastReply:
    """The answer to a question for a forecast.

    Args:
        asked: the torque that is planned; None for what came since the last measurement.

    Raises:
        NothingLearned: ask again later.
        BadInput: the question is none, or what a forecast needs does not come.
    """
    check_trained(node.served.model)
    stand_in, served, smoothing = node.stand_in, node.served, node.batches.smoothing
    believed = node.current_warnings.paused is None
    if asked is None:
        ahead = stand_in.since_measured(served.model, smoothing, believed)
    else:
        t, torque = np.array(asked.t), np.array(asked.torque)
        at = t if asked.at is None else np.array(asked.at)
        if t.size != torque.size:
            raise BadInput(f"t holds {t.size} times and torque {torque.size} values; give one for each")
        if (np.diff(t) < 0.0).any() or t[0] < 0.0 or (np.diff(at) < 0.0).any() or at[0] < 0.0:
            raise BadInput(
                "times are in seconds since the last measurement: let them begin at zero or later and increase"
            )
        refuse_steps(t, "the times of a plan")
        refuse_steps(at, "the times of the answers")
        refuse_effort(torque, node.config.vehicle.torque_limit, node.words)
        ahead = stand_in.under(served.model, smoothing, believed, t, torque, at)
    return wire.ForecastReply(
        since=ahead.start.time,
        measured=ahead.start.rate,
        **ahead.columns,
        iteration=served.iteration,
        revision=served.revision,
    )


def estimate(node: LearnerNode, silent_s: float | None) -> wire.Estimate | None:
    """The estimate to publish while the gyro is silent or doubted; None if it is neither, or none is possible.

    Args:
        silent_s: for how long it has been silent, by the clock on the wall [s]; None where it is not.
    """
    paused = node.current_warnings.paused
    if (silent_s is None and paused is None) or not node.served.model.is_trained:
        return None
    try:
        ahead = node.stand_in.since_measured(node.served.model, node.batches.smoothing, paused is None)
    except BadInput:
        return None
    return _last(node, ahead, f"the {node.words.rate} is silent" if paused is None else f"learning is paused: {paused}")


def _last(node: LearnerNode, ahead: ForecastFromStart, why: str) -> wire.Estimate:
    newest = {name: values[-1] for name, values in ahead.columns.items()}
    age = newest["t"] - ahead.start.time
    left = (
        ""
        if newest["worth"]
        else "; this estimate is too uncertain to be useful: its interval is as wide as the range of the usual rates"
    )
    return wire.Estimate(
        **newest,
        since=ahead.start.time,
        age_s=age,
        why=f"{why}; the last valid measurement is {age:.1f} s old{left}",
        iteration=node.served.iteration,
        revision=node.served.revision,
    )
