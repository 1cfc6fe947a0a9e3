"""What a free run needs beside the model: everything that is known beforehand, and dry friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from incsvr.effects import Effect, Signals, Term
from incsvr.effects.signals import FLATTEST
from incsvr.tracing.run import Array

if TYPE_CHECKING:
    from incsvr.tracing.model import TracedModel

FASTEST = 5.0
"""A free run is held within this many times the fastest rate of the fitted recordings: divergence stays finite."""

CELLS = 1000
"""Of the table of d(r), to either side."""

_Effects: TypeAlias = Sequence[tuple[Effect, Term]]
"""Effects of one model, each with its values."""


def rub(rate: Array, loss: Array, width: Array) -> Array:
    """Dry friction for half a step, exactly: it slows the turn, ends it, and never turns the vehicle (G. Strang's
    splitting, SIAM J. Numer. Anal. 5, 1968; linearised, so steep a friction would stall every reversal for a step)."""
    loss = np.where(rate > 0.0, loss[0], loss[1])
    rubbed: Array = np.sign(rate) * np.maximum(np.abs(rate) - loss * np.tanh(np.abs(rate) / width), 0.0)
    return rubbed


class Plan:
    """What free runs may know beforehand: thrust, outside moments and drag factors, averaged over their steps.

    Those of several models go side by side, each on spans of its own: it is calls that cost, not arithmetic. So what
    depends on the motion is asked once for all models that have it with the same inner parameters.
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
        effects = [list(zip(model.effects(), model.terms, strict=True)) for model in models]
        inputs = [self._inputs(*each, signals) for each in zip(models, effects, spans, strict=True)]
        self._drive, self._factor, self._thrust = (np.concatenate(each, axis=1) for each in zip(*inputs, strict=True))
        motion = [[(e, t) for e, t in each if e.acts == "motion" and not e.dry_friction] for each in effects]
        self._alike = _alike(motion, count)
        read = {name for each in motion for effect, _ in each for name in effect.channels}
        cut = [signals.pieces(each) for each in spans] if read else []
        self._channels = {
            name: np.concatenate([self._cells(each.channels[name], each.runs()) for each in cut], axis=1)
            for name in sorted(read)
        }
        inertia = [
            model.inertia + sum(t.coefficients[0] for e, t in each if e.acts == "inertia")
            for model, each in zip(models, effects, strict=True)
        ]
        friction_terms = [next((t for e, t in each if e.dry_friction), None) for each in effects]
        loss = [
            (0.0, 0.0) if t is None else (max(t.coefficients[0], 0.0), max(t.coefficients[-1], 0.0))
            for t in friction_terms
        ]
        self._inertia = np.repeat(inertia, count)
        self.friction = np.repeat(loss, count, axis=0).T / self._inertia  # forward and backward
        self.creep = np.repeat([1.0 if term is None else term.inner[-1] for term in friction_terms], count)
        # d(r) in even cells: the one in which a rate lies is known without a search
        tables = [model.drag() for model in models]
        self._drag = np.concatenate([table.values for table in tables])
        self._drag_step = np.diff(self._drag, append=0.0)
        self._table = np.repeat(np.arange(len(tables)) * (2 * CELLS + 1), count)
        self._cells_per_rate = np.repeat([1.0 / table.step for table in tables], count)
        self._slopes = dict[tuple[float, int], Array]()
        self.limit = CELLS / self._cells_per_rate
        first = [span.start for span in every]
        self.rate, self.heading = signals.rate[first], signals.heading[first]
        self.water, self._keep = self._moving(signals, first)

    def _inputs(
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
            steps = (x.size - 1) // self._hop
            total = np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1]))])[:: self._hop]
            out[:steps, k] = np.diff(total[: steps + 1]) / self._hop
            out[steps:, k] = out[steps - 1, k] if steps else x[0]
        return out

    def _moving(self, signals: Signals, first: Sequence[int]) -> tuple[Array, Array]:
        """(constants, runs) each: the rate of the moving water at first, and the part of it that stays for a step."""
        water = np.zeros((max(len(alike.constants) for alike in self._alike), len(first)))
        keep = np.zeros_like(water)
        for alike in self._alike:
            for k, constant in enumerate(alike.constants):
                water[k, alike.own] = signals.lowpass(signals.rate, constant)[first[alike.own]]
                keep[k, alike.own] = np.exp(-self.step / constant)
        return water, keep

    def moved(self, water: Array, rate: Array) -> Array:
        """The water a step on, in which the vehicle turned at this rate in the mean."""
        return self._keep * water + (1.0 - self._keep) * rate if water.size else water

    def acceleration(self, k: int, rate: Array, nudge: Array, heading: Array, water: Array) -> tuple[Array, Array]:
        """(runs,) at the rate of each run and at one that is larger by `nudge`; in one go: calls are what costs."""
        both = np.stack([rate, rate + nudge])
        drag = self._drag_at(both)
        moment = self._drive[k] - self._factor[k] * drag
        for alike in self._alike:
            if alike.motions:
                own = alike.own
                moment[:, own] -= self._of_motion(alike, both[:, own], drag[:, own], k, heading, water)
        push, there = moment / self._inertia
        return push, there

    def _of_motion(self, alike: _Alike, both: Array, drag: Array, k: int, heading: Array, water: Array) -> Array:
        """(2, own) what the effects of models that are alike take that look at how the vehicle moves, in step k."""
        own = alike.own
        of_water = water[: len(alike.constants), own]
        moving = {constant: _twice(w) for constant, w in zip(alike.constants, of_water, strict=True)}
        now = _Instant(
            both.ravel(), drag.ravel(), _twice(heading[own]), _twice(self._thrust[k, own]), moving,
            lambda rate: self._drag_at(rate.reshape(both.shape), own).ravel(),
            lambda usual: self._slope(usual, own),
            {name: _twice(values[k, own]) for name, values in self._channels.items()},
        )  # fmt: skip
        taken = np.zeros(both.size)
        for effect, inner, coefficients in alike.motions:
            # an instant has of the signals what such effects look at, and no more; of each run a coefficient
            columns = effect.columns(now, inner, coefficients)  # type: ignore[arg-type]
            for column, coefficient in zip(columns.T, coefficients, strict=True):
                taken += coefficient * column
        return taken.reshape(both.shape)

    def _slope(self, usual: float, own: slice) -> Array:
        """(2 own,) as `Signals.drag_slope`; that of a run stays what it is."""
        if (usual, own.start) not in self._slopes:
            sides = np.full(self._table[own].size, usual)
            rise = self._drag_at(sides, own) - self._drag_at(-sides, own)
            self._slopes[usual, own.start] = _twice(np.maximum(rise / (2.0 * usual), FLATTEST))
        return self._slopes[usual, own.start]

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


@dataclass(frozen=True, slots=True)
class _Alike:
    """Models whose effects of the motion have the same inner parameters.

    Attributes:
        own: their runs.
        motions: each such effect, its inner parameters, and of each coefficient (2 own,) what it is in each run.
        constants: the time constants of the water that these look at [s].
    """

    own: slice
    motions: tuple[tuple[Effect, tuple[float, ...], tuple[Array, ...]], ...]
    constants: tuple[float, ...]


def _alike(motion: Sequence[_Effects], count: Sequence[int]) -> list[_Alike]:
    """Successive models that are alike; `count` runs of each."""
    ends, found = np.cumsum(count).tolist(), []
    keys = [tuple((effect.key, term.inner) for effect, term in each) for each in motion]
    for _, group in groupby(range(len(keys)), keys.__getitem__):
        first, *others = group
        models = [first, *others]
        motions = []
        for k, (effect, term) in enumerate(motion[first]):
            each = np.repeat([motion[m][k][1].coefficients for m in models], [count[m] for m in models], axis=0)
            motions.append((effect, term.inner, tuple(_twice(coefficient) for coefficient in each.T)))
        constants = tuple(term.inner[-1] for effect, term in motion[first] if effect.searched)
        found.append(_Alike(slice(ends[first] - count[first], ends[models[-1]]), tuple(motions), constants))
    return found


@dataclass(frozen=True, slots=True)
class _Instant:
    """What `motion` effects may look at during a free run, one value for each run."""

    rate: Array
    damping: Array
    heading: Array
    applied: Array
    water: Mapping[float, Array]
    drag_at: Callable[[Array], Array]
    drag_slope: Callable[[float], Array]
    channels: Mapping[str, Array]

    def lowpass(self, values: Array, time_constant: float) -> Array:
        """The moving water's rate: of the simulated rate, the only signal that an effect filters while it moves."""
        return self.water[time_constant]

    def over_jumps(self, values: Array, act: Callable[[Array], Array]) -> Array:
        """act(values): an instant holds no jump of the command."""
        return act(values)
