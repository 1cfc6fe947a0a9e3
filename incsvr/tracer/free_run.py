"""What a free run needs beside the model: everything that is known beforehand, and dry friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from incsvr.effects import Effect, Signals, Term
from incsvr.tracer.run import Array

if TYPE_CHECKING:
    from incsvr.tracer.forward import TracedModel

FASTEST = 5.0
"""A free run is held within this many times the fastest rate of the fitted recordings: divergence stays finite."""

CELLS = 1000
"""Of the table of d(r), to either side."""


def rub(rate: Array, loss: float, width: float) -> Array:
    """Dry friction for half a step, exactly: it slows the turn, ends it, and never turns the vehicle (G. Strang's
    splitting, SIAM J. Numer. Anal. 5, 1968; linearised, so steep a friction would stall every reversal for a step)."""
    rubbed: Array = np.sign(rate) * np.maximum(np.abs(rate) - loss * np.tanh(np.abs(rate) / width), 0.0)
    return rubbed


class Plan:
    """What a free run may know beforehand: thrust, outside moments and drag factors, averaged over its steps."""

    def __init__(self, model: TracedModel, signals: Signals, spans: Sequence[slice], hop: int) -> None:
        # the thrust at the start of a span is what the command before it left behind
        signals = replace(signals, applied=model.thrust(signals)).pieces(spans)
        self.step = hop * signals.step
        self._runs = signals.runs()
        self._hop = hop
        self.length = max((run.stop - run.start - 1) // hop for run in self._runs)
        seen = replace(
            signals, inertia=model.inertia, scale=model.scale, block=model.block, origin=model.origin,
            damping=np.ones(len(signals)), acceleration=np.ones(len(signals)),
        )  # fmt: skip
        outside = thrust = signals.applied
        factor = np.ones(len(signals))
        friction, self.creep = 0.0, 1.0
        self.constants: list[float] = []
        self._motion: list[tuple[Effect, Term]] = []
        self._inertia = model.inertia
        for effect, term in zip(model.effects(), model.terms, strict=True):
            if effect.acts == "outside":
                outside = outside - effect.columns(seen, term.inner, term.coefficients) @ np.array(term.coefficients)
            elif effect.acts == "damping":
                factor = factor * effect.factor(seen, term)
            elif effect.acts == "inertia":
                self._inertia += term.coefficients[0]
            elif effect.dry:
                friction, self.creep = term.coefficients[0], term.inner[-1]
            elif effect.acts == "motion":
                self._motion.append((effect, term))
                if effect.searched:
                    self.constants.append(term.inner[-1])
        self.friction = max(friction, 0.0) / self._inertia
        cells = (self._cells(values) for values in (outside, factor, thrust))
        self._drive, self._factor, self._thrust = (np.concatenate([each, each], axis=1) for each in cells)
        # d(r) in even cells: the one in which a rate lies is known without a search
        rate, self._drag = model.drag()
        self._cells_per_rate = CELLS / float(rate[-1])
        self._drag_step = np.diff(self._drag)

    def _cells(self, values: Array) -> Array:
        """(length, runs): means between successive integration steps; a run that ended holds its last value."""
        out = np.empty((self.length, len(self._runs)))
        for k, run in enumerate(self._runs):
            x = values[run]
            whole = (x.size - 1) // self._hop
            total = np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1]))])[:: self._hop]
            out[:whole, k] = np.diff(total[: whole + 1]) / self._hop
            out[whole:, k] = out[whole - 1, k] if whole else x[0]
        return out

    def acceleration(
        self, k: int, rate: Array, nudge: float, heading: Array, water: Mapping[float, Array]
    ) -> tuple[Array, Array]:
        """(runs,) at the rate of each run and at one that is larger by `nudge`; in one go: calls are what costs."""
        runs = rate.size
        both = np.concatenate([rate, rate + nudge])
        moment = self._drive[k] - self._factor[k] * self._drag_at(both)
        if self._motion:
            twice = {constant: np.concatenate([values, values]) for constant, values in water.items()}
            now = _Instant(both, np.concatenate([heading, heading]), self._thrust[k], twice, self._drag_at)
            for effect, term in self._motion:
                columns = effect.columns(now, term.inner, term.coefficients)  # type: ignore[arg-type]
                moment = moment - columns @ np.array(term.coefficients)
        acceleration: Array = moment / self._inertia
        return acceleration[:runs], acceleration[runs:]

    def _drag_at(self, rate: Array) -> Array:
        at = np.fmin(np.fmax(rate * self._cells_per_rate + CELLS, 0.0), 2.0 * CELLS - 1e-9)  # no number: any cell
        cell = at.astype(np.intp)
        drag: Array = self._drag[cell] + (at - cell) * self._drag_step[cell]
        return drag

    def index(self) -> tuple[Array, Array, Array]:
        """Grid index of every simulated rate, its run and its step."""
        counts = [(run.stop - run.start - 1) // self._hop + 1 for run in self._runs]
        rows = [np.arange(count) for count in counts]
        index = np.concatenate([run.start + self._hop * r for run, r in zip(self._runs, rows, strict=True)])
        return index, np.repeat(np.arange(len(counts)), counts), np.concatenate(rows)


@dataclass(frozen=True, slots=True)
class _Instant:
    """What `motion` effects may look at during a free run, one value for each run."""

    rate: Array
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
