"""The torque of a traced model's effects while the vehicle moves, piece by piece as the streams arrive.

    I₀ ṙ + d(r) + Σ effects = τ   ⟹   d(r) = (τ − I₀ ṙ − Σ effects) / Π factors

The effects are the tracer's own, the same code on the same kind of grid. What they remember of the past (a lag, the
moving water, the turned angle) is carried from piece to piece as a value, so that it makes no difference, to the last
bit, where a piece ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects import Effect, Signals, Term
from incsvr.model_trace.model import TracedModel
from incsvr.numerics import Array
from incsvr.signals import RUN_PAUSE_S
from incsvr.tracing.of_model import drag_of, effects_of

HEADING_CHANNEL = "heading"
"""The channel of the heading."""
HEADING_EFFECTS = ("heading_current", "tether", "unexplained:heading")
"""The effects that look at the heading."""
_TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class FilterState:
    """The memory between two pieces.

    Attributes:
        index: of the last grid point; None before the first.
        rate: yaw rate there [rad/s].
        heading: the turned angle since the beginning, or the heading as it was received [rad]; None before the first.
        turns: whole turns of a received heading.
        filters: the state of each effect's filter, by the effect's name.
    """

    index: int | None = None
    rate: float = 0.0
    heading: float | None = None
    turns: int = 0
    filters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class GridSegment:
    """Points of the fine grid, in their order; they may pause.

    Attributes:
        index: (n,) number of each point; it stands at index · step.
        step: of the grid [s].
        rate: (n,) yaw rate [rad/s].
        torque: (n,) as commanded [N m].
        delayed: (n,) the torque of `Compensation.delay` ago [N m].
        channels: (n,) each; `heading` [rad] where it is received.
    """

    index: NDArray[np.int64]
    step: float
    rate: Array
    torque: Array
    delayed: Array
    channels: Mapping[str, Array]

    @property
    def time(self) -> Array:
        """(n,) stamps [s]."""
        return np.asarray(self.index * self.step, dtype=np.float64)

    def take(self, part: slice) -> GridSegment:
        channels = {name: values[part] for name, values in self.channels.items()}
        return GridSegment(
            self.index[part], self.step, self.rate[part], self.torque[part], self.delayed[part], channels
        )  # fmt: skip


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
            KeyError, ValueError, IndexError: it holds terms that this catalogue does not know in this form.
        """
        pairs = list(zip(effects_of(model), model.terms, strict=True))
        kept = tuple(term for effect, term in pairs if not effect.needs_clock)
        left_out = tuple(term.effect for effect, term in pairs if effect.needs_clock)
        found = Compensation(replace(model, terms=kept), left_out)
        still = np.zeros(2)
        found.split(
            GridSegment(np.arange(2), 0.02, still, still, still, dict.fromkeys(found.channels, still)), FilterState()
        )
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names, in the order in which they were added."""
        return tuple(term.effect for term in self.model.terms)

    @property
    def channels(self) -> tuple[str, ...]:
        """The further channels that the effects read; the heading is integrated where it does not come."""
        return tuple(sorted({channel for effect in effects_of(self.model) for channel in effect.channels}))

    @property
    def of_heading(self) -> bool:
        """Whether an effect looks at the heading."""
        return any(name in HEADING_EFFECTS for name in self.names)

    def reads(self, known: Iterable[str]) -> tuple[str, ...]:
        """The known channels that the effects look at, the heading among them."""
        looked_at = {*self.channels, *([HEADING_CHANNEL] if self.of_heading else [])}
        return tuple(name for name in known if name in looked_at)

    @property
    def delay(self) -> float:
        """The dead time of the thrust [s]; negative where the torque's clock runs late."""
        return sum(term.coefficients[0] for term in self.model.terms if term.effect == "torque_delay")

    def pairs(self) -> list[tuple[Effect, Term]]:
        """The effects with their terms, in the order in which they were added."""
        return list(zip(effects_of(self.model), self.model.terms, strict=True))

    def split(self, piece: GridSegment, carried: FilterState) -> tuple[list[Array], FilterState]:
        """The torque of each effect, in the order of `pairs`, and the memory after this piece.

        (n,) each: a moment [N m]; of an effect that scales the damping its factor; of an inertia zero, because it takes
        its part of the acceleration, which is not looked at here.
        """
        anew = np.flatnonzero(np.diff(piece.index) * piece.step >= RUN_PAUSE_S) + 1
        edges = [0, *anew.tolist(), piece.index.size]
        found: list[list[Array]] = []
        for first, last in pairwise(edges):
            part = piece.take(slice(first, last))
            if carried.index is not None and (part.index[0] - carried.index) * piece.step >= RUN_PAUSE_S:
                carried = FilterState(
                    turns=carried.turns, heading=carried.heading if HEADING_CHANNEL in piece.channels else None
                )
            values, carried = self._stretch(part, carried)
            found.append(values)
        return [np.concatenate(values) for values in zip(*found, strict=True)], carried

    def _stretch(self, piece: GridSegment, carried: FilterState) -> tuple[list[Array], FilterState]:
        """Corrects points that belong together; short pauses are bridged as if time had stood still."""
        pairs, model = self.pairs(), self.model
        heading, carried = _heading(piece, carried)
        filters: dict[str, float] = dict(carried.filters)
        seen = _SegmentSignals(
            step=piece.step, start=np.array([0, piece.index.size], dtype=np.intp), time=piece.time,
            rate=piece.rate, torque=piece.torque, channels=piece.channels, heading=heading, inertia=model.inertia,
            scale=model.scale, block=model.block, damping=model.damping_at(piece.rate), drag=drag_of(model),
            filters=filters,
        )  # fmt: skip
        values: dict[int, Array] = {}
        command = piece.torque
        for k, (effect, term) in sorted(enumerate(pairs), key=lambda each: each[1][0].stage):
            if effect.acts == "thrust":
                # The delay is taken from the stamps: the grid would blur it.
                late = term.effect == "torque_delay"
                after = piece.delayed if late else effect.thrust(command, replace(seen, effect=effect.key), term)
                values[k], command = command - after, after
        seen = replace(seen, applied=command)
        for k, (effect, term) in enumerate(pairs):
            if effect.acts == "damping":
                values[k] = effect.factor(seen, term)
            elif effect.acts == "inertia":
                values[k] = np.zeros(piece.index.size)
            elif effect.acts != "thrust":
                columns = effect.columns(replace(seen, effect=effect.key), term.inner, term.coefficients)
                # Column by column: a matrix product rounds by where in the piece a point stands.
                total = np.zeros(piece.index.size)
                for column, coefficient in zip(columns.T, term.coefficients, strict=True):
                    total = total + column * coefficient
                values[k] = total
        last = replace(carried, index=int(piece.index[-1]), rate=float(piece.rate[-1]), filters=filters)
        return [values[k] for k in range(len(pairs))], last


def plain_data(carried: FilterState) -> dict[str, Any]:
    """The fields as plain data, exact to the bit in JSON."""
    return asdict(carried)


@dataclass(frozen=True, slots=True)
class _SegmentSignals(Signals):
    """The signals that an effect may read; its filter continues from the end of the piece before."""

    effect: str = ""
    filters: dict[str, float] = field(default_factory=dict)

    def lowpass(self, values: Array, time_constant: float) -> Array:
        """The low-pass of `Signals.lowpass`, continued over pieces."""
        half = 0.5 * self.step / time_constant
        gain, pole = half / (1.0 + half), (1.0 - half) / (1.0 + half)
        before = self.filters.get(self.effect, (1.0 - gain) * float(values[0]))
        out, after = lfilter([gain, gain], [1.0, -pole], values, zi=np.array([before]))
        self.filters[self.effect] = float(after[0])
        return np.asarray(out, dtype=np.float64)


def _heading(piece: GridSegment, carried: FilterState) -> tuple[Array, FilterState]:
    """(n,) the heading, counted on over whole turns [rad]: as received, else the integral of the yaw rate."""
    if HEADING_CHANNEL in piece.channels:
        received = piece.channels[HEADING_CHANNEL]
        before = received[0] if carried.heading is None else carried.heading
        jumps = np.rint(np.diff(received, prepend=before) / _TURN).astype(np.int64)
        turns = carried.turns - np.cumsum(jumps)
        return received + _TURN * turns, replace(carried, heading=float(received[-1]), turns=int(turns[-1]))
    first = int(piece.index[0]) if carried.index is None else carried.index
    step = piece.step * np.diff(piece.index, prepend=first)
    rate = np.concatenate(([piece.rate[0] if carried.index is None else carried.rate], piece.rate))
    turned = np.cumsum(np.concatenate(([carried.heading or 0.0], 0.5 * step * (rate[1:] + rate[:-1]))))[1:]
    return turned, replace(carried, heading=float(turned[-1]))
