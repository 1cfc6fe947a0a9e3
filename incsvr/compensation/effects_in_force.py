"""The torque of a traced model's effects while the vehicle moves, from the streams around some instants alone.

    I₀ ṙ + d(r) + Σ effects = τ   ⟹   d(r) = τ − I₀ ṙ − Σ effects

What effects remember of the past (a lag, the moving water) is worked out from five time constants before: less than a
hundredth of anything older is left.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from incsvr.model.efforts import Stage, lagged, means
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import of_rate, stream_of
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.streams import JUMP_S
from incsvr.tracing.model import TracedModel, parts

HEADING_CHANNEL = "heading"
"""The channel of the heading."""
CLOCK = "time"
"""The engine's name of a recording's own time."""
INERTIA = "inertia"
"""The effect that takes its part of the acceleration."""
FOLLOWED_BY_LEARNING = ("drag_drift", "drag_step")
"""Effects of the damping over time: the learned damping follows the vehicle by itself."""
MARGIN_CONSTANTS = 5.0
"""Time constants over which an effect remembers."""


@dataclass(frozen=True, slots=True)
class Compensation:
    """The effects of a traced model that hold on any recording.

    Attributes:
        model: the traced model, with these effects alone.
        left_out: names of the effects that refer to the clock of the recordings they were traced on.
    """

    model: TracedModel
    left_out: tuple[str, ...]

    @staticmethod
    def of(model: TracedModel) -> Compensation:
        """The effects of a traced model that apply to another recording.

        Raises:
            KeyError, ValueError, StopIteration: it holds rows that the engine does not know in this form.
        """
        kept = tuple(effect for effect in model.effects if CLOCK not in effect.signals)
        left_out = tuple(effect.name for effect in model.effects if CLOCK in effect.signals)
        found = Compensation(replace(model, effects=kept), left_out)
        still = np.array([0.0, 1.0]), np.zeros(2)
        found.parts(dict.fromkeys((YAW_RATE, TORQUE, *found.channels), still), still[0], 1.0)
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names, in the order in which they were added."""
        return tuple(effect.name for effect in self.model.effects)

    @property
    def channels(self) -> tuple[str, ...]:
        """The further streams that the effects read."""
        return tuple(sorted(set(self.streams.values()) - {YAW_RATE}))

    @property
    def streams(self) -> dict[str, str]:
        """The stream of each signal that the effects read, but of the effort."""
        model, axis = self.model, of_rate(self.model.axis)
        read = dict.fromkeys((model.axis, *(name for effect in model.effects for name in effect.signals)))
        return {name: YAW_RATE if name == model.axis else stream_of(axis, name) for name in read if name != axis.effort}

    @property
    def reads_turns(self) -> bool:
        """Whether an effect grows with the turned angle, so that whole turns count."""
        rows = (row for effect in self.model.effects for row in effect.rows)
        return any(
            factor.of == HEADING_CHANNEL and factor.kind not in ("sine", "cosine", "sine2", "cosine2")
            for row in rows
            for factor in (row.parts[0].one, row.parts[0].other)
        )

    def reads(self, known: Iterable[str]) -> tuple[str, ...]:
        """The known channels that the effects look at."""
        return tuple(name for name in known if name in self.channels)

    @property
    def delay(self) -> float:
        """The dead time of the thrust [s]; negative where the torque's clock runs late."""
        return self.model.theta.get(f"shift:{self.model.axis}", 0.0)

    @property
    def margin(self) -> float:
        """How long before an instant the streams count [s]."""
        axis, constants = self.model.axis, [0.0]
        for effect in self.model.effects:
            constants += [effect.value(kind, axis) or 0.0 for kind in ("lag", "spin")]
            constants += [effect.value("time", row.key) or 0.0 for row in effect.rows if row.follows]
        return MARGIN_CONSTANTS * max(constants)

    def parts(self, streams: Streams, time: Array, gap: float) -> dict[str, Array]:
        """By effect the torque that it takes [N m]: an inertia nothing, which takes its part of the acceleration.

        Args:
            streams: name → (stamps [s], values).
            time: (n,) even instants [s], n ≥ 2; what effects remember begins at the first.
            gap: the longest pause of yaw rate and torque [s].

        Returns:
            (n,) each, NaN where a stream is not known.
        """
        model, step = self.model, float(time[1] - time[0])
        edges = np.append(time, time[-1] + step) - 0.5 * step
        commands = _around(streams[TORQUE], edges[0] - max(self.delay, 0.0), edges[-1] - min(self.delay, 0.0))
        known = ~np.isnan(linear(commands, time, gap) + linear(commands, time - self.delay, gap))
        signals = {}
        for name, stream in self.streams.items():
            pause = gap if stream == YAW_RATE else JUMP_S
            signals[name] = linear(streams[stream], time, pause, stream == HEADING_CHANNEL and not self.reads_turns)
            here = ~np.isnan(signals[name])
            known &= here
            signals[name] = np.interp(time, time[here], signals[name][here]) if here.any() else np.zeros(time.size)
        for effect in model.effects:
            for row in effect.rows:
                if row.follows:
                    constant = effect.value("time", row.key) or step
                    signals[f"~{row.key}"] = lagged(signals[row.follows], step / constant)

        def effort(stage: Stage) -> Array:
            return means(commands, edges, "linear", stage, model.top)

        found = parts(model.effects, model.axis, signals, effort) if commands[0].size else {}
        return {name: np.where(known, found.get(name, 0.0), np.nan) for name in dict.fromkeys(self.names)}


def linear(stream: Stream, at: Array, gap: float, turning: bool = False) -> Array:
    """A stream at (n,) instants, linear between two stamps at most `gap` apart, else NaN; `turning` for an angle.

    Each value follows from its two neighbours alone, to the last bit.
    """
    time, value = stream
    if time.size < 2:
        return np.full(at.size, np.nan)
    after = np.searchsorted(time, at, side="left")
    inside = (after > 0) & (after < time.size)
    after = np.clip(after, 1, time.size - 1)
    width, rise = time[after] - time[after - 1], value[after] - value[after - 1]
    if turning:
        rise = rise - 2.0 * np.pi * np.rint(rise / (2.0 * np.pi))
    found = value[after - 1] + (at - time[after - 1]) / width * rise
    return np.where(inside & (width <= gap), found, np.nan)


def _around(stream: Stream, begin: float, end: float) -> Stream:
    """The part of a stream between two instants, with the value before and the one after."""
    time, value = stream
    first = max(int(np.searchsorted(time, begin, side="right")) - 1, 0)
    last = int(np.searchsorted(time, end, side="left")) + 1
    return time[first:last], value[first:last]
