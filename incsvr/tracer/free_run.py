"""What a free run needs beside the model: everything that is known beforehand, and dry friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from incsvr.effects import Effect, Signals, Term
from incsvr.tracer.run import Array

if TYPE_CHECKING:
    from incsvr.tracer.forward import TracedModel

FASTEST = 5.0
"""A free run is held within this many times the fastest rate of the fitted recordings: divergence stays finite."""

CELLS = 1000
"""Of the table of d(r), to either side."""

_Effects: TypeAlias = Sequence[tuple[Effect, Term]]
"""Effects of one model, each with its values."""


def rub(rate: Array, loss: Array, width: Array) -> Array:
    """Dry friction for half a step, exactly: it slows the turn, ends it, and never turns the vehicle (G. Strang's
    splitting, SIAM J. Numer. Anal. 5, 1968; linearised, so steep a friction would stall every reversal for a step)."""
    rubbed: Array = np.sign(rate) * np.maximum(np.abs(rate) - loss * np.tanh(np.abs(rate) / width), 0.0)
    return rubbed


class Plan:
    """What free runs may know beforehand: thrust, outside moments and drag factors, averaged over their steps.

    Those of several models go side by side, each on spans of its own: it is calls that cost, not arithmetic.
    """

    def __init__(
        self, models: Sequence[TracedModel], signals: Signals, spans: Sequence[Sequence[slice]], hop: int
    ) -> None:
        self.step = hop * signals.step
        self._hop = hop
        every = [span for each in spans for span in each]
        self._sizes = [span.stop - span.start for span in every]
        self.length = max((size - 1) // hop for size in self._sizes)
        count = [len(each) for each in spans]
        ends = np.cumsum(count).tolist()
        self._own = [slice(end - n, end) for n, end in zip(count, ends, strict=True)]
        effects = [list(zip(model.effects(), model.terms, strict=True)) for model in models]
        courses = [self._course(*each, signals) for each in zip(models, effects, spans, strict=True)]
        self._drive, self._factor, self._thrust = (np.concatenate(each, axis=1) for each in zip(*courses, strict=True))
        self._motion = [[(e, t) for e, t in each if e.acts == "motion" and not e.dry] for each in effects]
        inertia = [
            model.inertia + sum(t.coefficients[0] for e, t in each if e.acts == "inertia")
            for model, each in zip(models, effects, strict=True)
        ]
        dry = [next((t for e, t in each if e.dry), None) for each in effects]
        loss = [0.0 if term is None else max(term.coefficients[0], 0.0) for term in dry]
        self._inertia = np.repeat(inertia, count)
        self.friction = np.repeat(loss, count) / self._inertia
        self.creep = np.repeat([1.0 if term is None else term.inner[-1] for term in dry], count)
        # d(r) in even cells: the one in which a rate lies is known without a search
        tables = [model.drag() for model in models]
        self._drag = np.concatenate([table.values for table in tables])
        self._drag_step = np.diff(self._drag, append=0.0)
        self._table = np.repeat(np.arange(len(tables)) * (2 * CELLS + 1), count)
        self._cells_per_rate = np.repeat([1.0 / table.step for table in tables], count)
        self.limit = CELLS / self._cells_per_rate
        first = [span.start for span in every]
        self.rate, self.heading = signals.rate[first], signals.heading[first]
        self.water, self._keep = self._moving(signals, first)

    def _course(
        self, model: TracedModel, effects: _Effects, spans: Sequence[slice], signals: Signals
    ) -> tuple[Array, Array, Array]:
        """(length, runs) each: the moment that drives the vehicle, the factor of its drag, and the thrust."""
        # the thrust at the start of a span is what the command before it left behind
        signals = replace(signals, applied=model.thrust(signals)).pieces(spans)
        seen = replace(
            signals, inertia=model.inertia, scale=model.scale, block=model.block, origin=model.origin,
            damping=np.ones(len(signals)), acceleration=np.ones(len(signals)),
        )  # fmt: skip
        outside = thrust = signals.applied
        factor = np.ones(len(signals))
        for effect, term in effects:
            if effect.acts == "outside":
                outside = outside - effect.columns(seen, term.inner, term.coefficients) @ np.array(term.coefficients)
            elif effect.acts == "damping":
                factor = factor * effect.factor(seen, term)
        runs = signals.runs()
        return self._cells(outside, runs), self._cells(factor, runs), self._cells(thrust, runs)

    def _cells(self, values: Array, runs: Sequence[slice]) -> Array:
        """(length, runs): means between successive integration steps; a run that ended holds its last value."""
        out = np.empty((self.length, len(runs)))
        for k, run in enumerate(runs):
            x = values[run]
            whole = (x.size - 1) // self._hop
            total = np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1]))])[:: self._hop]
            out[:whole, k] = np.diff(total[: whole + 1]) / self._hop
            out[whole:, k] = out[whole - 1, k] if whole else x[0]
        return out

    def _moving(self, signals: Signals, first: Sequence[int]) -> tuple[Array, Array]:
        """(constants, runs) each: the rate of the moving water at first, and the part of it that stays for a step."""
        constants = [_constants(motion) for motion in self._motion]
        water = np.zeros((max(map(len, constants)), len(first)))
        keep = np.zeros_like(water)
        for own, each in zip(self._own, constants, strict=True):
            for k, constant in enumerate(each):
                water[k, own] = signals.lowpass(signals.rate, constant)[first[own]]
                keep[k, own] = np.exp(-self.step / constant)
        return water, keep

    def moved(self, water: Array, rate: Array) -> Array:
        """The water a step on, in which the vehicle turned at this rate in the mean."""
        return self._keep * water + (1.0 - self._keep) * rate if water.size else water

    def acceleration(self, k: int, rate: Array, nudge: Array, heading: Array, water: Array) -> tuple[Array, Array]:
        """(runs,) at the rate of each run and at one that is larger by `nudge`; in one go: calls are what costs."""
        both = np.stack([rate, rate + nudge])
        drag = self._drag_at(both)
        moment = self._drive[k] - self._factor[k] * drag
        for own, motion in zip(self._own, self._motion, strict=True):
            if motion:
                at = both[:, own], drag[:, own]
                moment[:, own] -= self._of_motion(motion, own, at, self._thrust[k], heading, water)
        push, there = moment / self._inertia
        return push, there

    def _of_motion(
        self, motion: _Effects, own: slice, at: tuple[Array, Array], thrust: Array, heading: Array, water: Array
    ) -> Array:
        """(2, own) what the effects of one model take that look at how the vehicle moves; `at` rates and their drag."""
        one = slice(own.start, own.start + 1)  # all of these have its table
        moving = {constant: _twice(w) for constant, w in zip(_constants(motion), water[:, own], strict=True)}
        both, drag = at
        now = _Instant(
            both.ravel(), drag.ravel(), _twice(heading[own]), _twice(thrust[own]), moving,
            lambda rate: self._drag_at(rate, one),
        )  # fmt: skip
        taken = np.zeros(both.size)
        for effect, term in motion:
            # an instant has of the signals what such effects look at, and no more
            columns = effect.columns(now, term.inner, term.coefficients)  # type: ignore[arg-type]
            taken += columns @ np.array(term.coefficients)
        return taken.reshape(both.shape)

    def _drag_at(self, rate: Array, own: slice = slice(None)) -> Array:
        """d at rates (…, own) of these runs, (…, own)."""
        at = rate * self._cells_per_rate[own] + CELLS
        at = np.fmin(np.fmax(at, 0.0), 2.0 * CELLS - 1e-9)  # no number: any cell
        cell = at.astype(np.intp)
        at -= cell
        cell += self._table[own]
        drag: Array = self._drag[cell] + at * self._drag_step[cell]
        return drag

    def index(self) -> tuple[Array, Array, Array]:
        """Of every simulated rate its index in the spans, one after the other, its run and its step."""
        counts = [(size - 1) // self._hop + 1 for size in self._sizes]
        start = np.cumsum([0, *self._sizes[:-1]])
        rows = [np.arange(count) for count in counts]
        index = np.concatenate([first + self._hop * r for first, r in zip(start, rows, strict=True)])
        return index, np.repeat(np.arange(len(counts)), counts), np.concatenate(rows)


def _twice(values: Array) -> Array:
    return np.concatenate([values, values])  # np.tile takes five times as long on so few


def _constants(motion: _Effects) -> list[float]:
    """The time constants of the water that the effects of one model look at [s]."""
    return [term.inner[-1] for effect, term in motion if effect.searched]


@dataclass(frozen=True, slots=True)
class _Instant:
    """What `motion` effects may look at during a free run, one value for each run."""

    rate: Array
    damping: Array
    heading: Array
    applied: Array
    water: Mapping[float, Array]
    drag_at: Callable[[Array], Array]

    def lowpass(self, values: Array, time_constant: float) -> Array:
        """The moving water's rate: of the simulated rate, the only signal that an effect filters while it moves."""
        return self.water[time_constant]

    def over_jumps(self, values: Array, act: Callable[[Array], Array]) -> Array:
        """act(values): an instant holds no jump of the command."""
        return act(values)
