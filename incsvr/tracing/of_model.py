"""A traced model by the catalogue: its effects, its simulation, and every prediction split into parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.effects import Effect, Signals, Term, catalogue
from incsvr.effects.even_table import EvenTable
from incsvr.model_trace.model import TABLE_RATES, TracedModel
from incsvr.model_trace.thresholds import TABLED_RATE_QUANTILES
from incsvr.numerics import Array
from incsvr.tracing.cells import plain
from incsvr.tracing.dynamics import MAX_RATE_FACTOR, Dynamics, MotionModel, Windows, drag_table
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit
from incsvr.tracing.hypothesis import Part


@dataclass(frozen=True, slots=True)
class TermModel(TracedModel):
    """A traced model with the catalogue's terms in place of the engine's effects."""

    terms: tuple[Term, ...] = ()
    offset: float = 0.0


def effects_of(model: TermModel) -> tuple[Effect, ...]:
    """The catalogue's effects of the terms, in their order."""
    channels = {term.effect.split(":", 1)[1] for term in model.terms if ":" in term.effect}
    known = catalogue(sorted(channels))
    return tuple(known[f"{t.effect}/{t.variant}" if t.variant else t.effect] for t in model.terms)


def drag_of(model: TermModel) -> EvenTable:
    """d [N m] over all rates of a free run [rad/s]."""
    return drag_table(model.damping_at, MAX_RATE_FACTOR * float(np.max(np.abs(model.rate))))


def motion_of(model: TermModel) -> MotionModel:
    """The model as a simulation needs it."""
    parts = tuple(Part(*pair) for pair in zip(effects_of(model), model.terms, strict=True))
    return MotionModel(drag_of(model), model.inertia, parts, model.offset)


def parts_of(model: TermModel, signals: Signals) -> dict[str, Array]:
    """The torque ledger: what each part takes of the torque, (n,) each [N m].

    `declared inertia` and `damping` first, then each effect under its name; `signals.acceleration` and
    `signals.rate` are the measured motion. Their sum is the predicted torque.
    """
    damping = model.damping_at(signals.rate)
    parts = {"declared inertia": model.inertia * signals.acceleration, "damping": damping}
    seen = replace(
        signals, damping=damping, drag=drag_of(model), inertia=model.inertia, scale=model.scale, block=model.block
    )
    command = signals.torque
    pairs = list(zip(effects_of(model), model.terms, strict=True))
    for effect, term in sorted(pairs, key=lambda pair: pair[0].stage):
        if effect.acts == "thrust":
            after = effect.thrust(command, seen, term)
            parts[term.effect], command = command - after, after
    seen = replace(seen, applied=command)
    for effect, term in pairs:
        if effect.acts == "inertia":
            parts[term.effect] = term.coefficients[0] * signals.acceleration
        elif effect.acts == "damping":
            parts[term.effect] = (effect.factor(seen, term) - 1.0) * damping
        elif effect.acts != "thrust":
            parts[term.effect] = effect.columns(seen, term.inner, term.coefficients) @ np.array(term.coefficients)
    return {name: parts[name] for name in ("declared inertia", "damping", *(term.effect for term in model.terms))}


def simulated(model: TermModel, signals: Signals, spans: Sequence[slice] | None = None) -> tuple[Array, Array]:
    """Free runs side by side on a grid whose torque holds from each point to the next.

    Args:
        signals: torque, channels, and of the motion what came before each free run: its first rate and heading, and
            of a memory the water that an earlier turn set in motion.
        spans: of the grid, each at least two points; all runs as a whole if not given.

    Returns:
        indices into the grid, span after span, and the simulated rate there [rad/s].
    """
    spans = signals.runs() if spans is None else spans
    seen = replace(signals, scale=model.scale, block=model.block, origin=model.origin, inertia=model.inertia)
    course = Dynamics(plain(seen), motion_of(model)).simulate(Windows.of([slice(s.start, s.stop - 1) for s in spans]))
    index = np.concatenate([np.arange(s.start, s.stop) for s in spans])
    return index, np.concatenate([course.rate[: s.stop - s.start, k] for k, s in enumerate(spans)])


def model_of(problem: Problem, fitted: Fit, sigma: float) -> TermModel:
    """A fitted hypothesis as a model; `sigma` is the deviation of a block residual [N m]."""
    s, hypothesis = problem.cells.signals, fitted.hypothesis
    low, high = (float(q) for q in np.quantile(s.rate, TABLED_RATE_QUANTILES))
    sides = [np.linspace(min(low, -1e-6), 0.0, TABLE_RATES), np.linspace(0.0, max(high, 1e-6), TABLE_RATES)]
    rate = np.unique(np.concatenate(sides))
    damping = np.asarray(hypothesis.damping @ hypothesis.basis.columns(rate))
    terms = tuple(part.term for part in hypothesis.parts)
    return TermModel(
        s.inertia, rate, damping, (), sigma, s.block, s.scale, s.origin, terms=terms, offset=hypothesis.offset
    )
