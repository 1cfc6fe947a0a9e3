"""The model with its effects as one value: it predicts, simulates, is saved, and splits every prediction into parts.

I₀ ṙ + d(r) + Σ effects = τ
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from incsvr.effects import Effect, Signals, Term, catalogue
from incsvr.effects.even_table import EvenTable
from incsvr.numerics import Array
from incsvr.tracing.cells import plain
from incsvr.tracing.dynamics import MAX_RATE_FACTOR, Dynamics, MotionModel, Windows, drag_table
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit
from incsvr.tracing.hypothesis import Part
from incsvr.tracing.thresholds import TABLED_RATE_QUANTILES

TABLE_RATES = 101
"""Rates of the table to either side."""


@dataclass(frozen=True, slots=True)
class TracedModel:
    """The declared model, its learned damping and the effects that were added.

    Attributes:
        inertia: I₀, as declared [kg m²].
        rate: (m,) increasing rates of the damping table [rad/s]; the trained range.
        damping: (m,) d(r) there [N m].
        terms: the effects with their values.
        sigma: deviation of a block residual [N m].
        block: the length of such a block [s].
        scale: T_c, the time scale of the vehicle's motion [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
        offset: by how much the torque acts later than these recordings stamped it, within a sample [s].
    """

    inertia: float
    rate: Array
    damping: Array
    terms: tuple[Term, ...]
    sigma: float
    block: float
    scale: float
    origin: tuple[float, float]
    offset: float = 0.0

    def effects(self) -> tuple[Effect, ...]:
        """The catalogue's effects of the terms, in their order."""
        channels = {term.effect.split(":", 1)[1] for term in self.terms if ":" in term.effect}
        known = catalogue(sorted(channels))
        return tuple(known[f"{t.effect}/{t.variant}" if t.variant else t.effect] for t in self.terms)

    def damping_at(self, rate: Array) -> Array:
        """d(r) [N m]; beyond the trained range the edge's drag continues quadratically."""
        inside = np.interp(rate, self.rate, self.damping)
        edge = np.where(rate > 0.0, self.rate[-1], self.rate[0])
        beyond = np.maximum(np.abs(rate / np.where(edge == 0.0, 1.0, edge)), 1.0)
        continued: Array = inside * beyond**2
        return continued

    def drag(self) -> EvenTable:
        """d [N m] over all rates of a free run [rad/s]."""
        return drag_table(self.damping_at, MAX_RATE_FACTOR * float(np.max(np.abs(self.rate))))

    def motion(self) -> MotionModel:
        """The model as a simulation needs it."""
        parts = tuple(Part(*pair) for pair in zip(self.effects(), self.terms, strict=True))
        return MotionModel(self.drag(), self.inertia, parts, self.offset)

    def parts(self, signals: Signals) -> dict[str, Array]:
        """The torque ledger: what each part takes of the torque, (n,) each [N m].

        `declared inertia` and `damping` first, then each effect under its name; `signals.acceleration` and
        `signals.rate` are the measured motion. Their sum is the predicted torque.
        """
        damping = self.damping_at(signals.rate)
        parts = {"declared inertia": self.inertia * signals.acceleration, "damping": damping}
        seen = replace(
            signals, damping=damping, drag=self.drag(), inertia=self.inertia, scale=self.scale, block=self.block
        )
        command = signals.torque
        pairs = list(zip(self.effects(), self.terms, strict=True))
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
        return {name: parts[name] for name in ("declared inertia", "damping", *(term.effect for term in self.terms))}

    def simulate(self, signals: Signals, spans: Sequence[slice] | None = None) -> tuple[Array, Array]:
        """Free runs side by side on a grid whose torque holds from each point to the next.

        Args:
            signals: torque, channels, and of the motion what came before each free run: its first rate and heading, and
                of a memory the water that an earlier turn set in motion.
            spans: of the grid, each at least two points; all runs as a whole if not given.

        Returns:
            indices into the grid, span after span, and the simulated rate there [rad/s].
        """
        spans = signals.runs() if spans is None else spans
        seen = replace(signals, scale=self.scale, block=self.block, origin=self.origin, inertia=self.inertia)
        course = Dynamics(plain(seen), self.motion()).simulate(Windows.of([slice(s.start, s.stop - 1) for s in spans]))
        index = np.concatenate([np.arange(s.start, s.stop) for s in spans])
        return index, np.concatenate([course.rate[: s.stop - s.start, k] for k, s in enumerate(spans)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data, exact to the last bit through JSON."""
        data = asdict(self)
        data["rate"], data["damping"] = self.rate.tolist(), self.damping.tolist()
        return data

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TracedModel:
        terms = tuple(
            Term(t["effect"], t["variant"], tuple(t["coefficients"]), tuple(t["inner"])) for t in data["terms"]
        )
        low, high = data["origin"]
        return TracedModel(
            data["inertia"], np.array(data["rate"]), np.array(data["damping"]), terms,
            data["sigma"], data["block"], data["scale"], (low, high), data.get("offset", 0.0),
        )  # fmt: skip


def model_of(problem: Problem, fitted: Fit, sigma: float) -> TracedModel:
    """A fitted hypothesis as a model; `sigma` is the deviation of a block residual [N m]."""
    s, hypothesis = problem.cells.signals, fitted.hypothesis
    low, high = (float(q) for q in np.quantile(s.rate, TABLED_RATE_QUANTILES))
    sides = [np.linspace(min(low, -1e-6), 0.0, TABLE_RATES), np.linspace(0.0, max(high, 1e-6), TABLE_RATES)]
    rate = np.unique(np.concatenate(sides))
    damping = np.asarray(hypothesis.damping @ hypothesis.basis.columns(rate))
    terms = tuple(part.term for part in hypothesis.parts)
    return TracedModel(s.inertia, rate, damping, terms, sigma, s.block, s.scale, s.origin, hypothesis.offset)
