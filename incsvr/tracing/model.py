"""The model with its effects as one value: it predicts, simulates, is saved, and splits every prediction into parts.

    I₀ ṙ + d(r) + Σ effects = τ

The free run integrates the yaw rate from its first measured value with the torque and the other channels alone;
heading, memory, lag and delay run on the simulated rate. Integrator: exponential Rosenbrock–Euler (second order, stable
for stiff friction; M. Hochbruck, A. Ostermann, Acta Numerica 19, 2010).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from incsvr.effects import Effect, Signals, Term, catalogue
from incsvr.effects.even_table import EvenTable
from incsvr.tracing.free_run import CELLS, FASTEST, Plan, rub
from incsvr.tracing.run import Array

STEPS = 28.0
"""Of the free run's integration, in a time scale."""


@dataclass(frozen=True, slots=True)
class TracedModel:
    """The declared model, its learned damping and the effects that were added.

    Attributes:
        inertia: I₀, as declared [kg m²].
        rate: (m,) increasing rates of the damping table [rad/s]; the trained range.
        damping: (m,) d(r) there [N m].
        terms: the effects with their values.
        sigma: deviation of a block residual [N m].
        block: T_b, the length of such a block [s].
        scale: T_c, the time scale of the vehicle's motion [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
    """

    inertia: float
    rate: Array
    damping: Array
    terms: tuple[Term, ...]
    sigma: float
    block: float
    scale: float
    origin: tuple[float, float]

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
        """d [N m] over all rates of a free run [rad/s], 2 CELLS + 1 of them."""
        fastest = FASTEST * float(np.max(np.abs(self.rate)))
        rate = np.linspace(-fastest, fastest, 2 * CELLS + 1)
        return EvenTable(-fastest, fastest / CELLS, self.damping_at(rate))

    def parts(self, signals: Signals) -> dict[str, Array]:
        """The torque ledger: what each part takes of the torque, (n,) each [N m].

        `inertia` and `damping` of the declared model first, then each effect under its name; `signals.acceleration` and
        `signals.rate` are the measured motion. Their sum is the predicted torque.
        """
        damping = self.damping_at(signals.rate)
        parts = {"declared inertia": self.inertia * signals.acceleration, "damping": damping}
        thrust = self.thrust(signals)
        seen = replace(
            signals, damping=damping, drag=self.drag(), applied=thrust, inertia=self.inertia,
            scale=self.scale, block=self.block,
        )  # fmt: skip
        command = signals.torque
        staged = sorted(zip(self.effects(), self.terms, strict=True), key=lambda pair: pair[0].stage)
        for effect, term in staged:
            if effect.acts == "thrust":
                after = effect.thrust(command, seen, term)
                parts[term.effect], command = command - after, after
            else:
                parts[term.effect] = effect.columns(seen, term.inner, term.coefficients) @ np.array(term.coefficients)
        return {name: parts[name] for name in ("declared inertia", "damping", *(term.effect for term in self.terms))}

    def predict(self, signals: Signals) -> Array:
        """The torque that the measured motion takes, (n,) [N m]."""
        total: Array = np.sum(list(self.parts(signals).values()), axis=0)
        return total

    def thrust(self, signals: Signals) -> Array:
        """(n,) the moment behind all thrust effects that do not depend on the motion [N m]."""
        command = signals.torque
        seen = replace(signals, scale=self.scale, block=self.block, origin=self.origin)
        for effect, term in sorted(zip(self.effects(), self.terms, strict=True), key=lambda pair: pair[0].stage):
            if effect.acts == "thrust":
                command = effect.thrust(command, seen, term)
        return command

    def simulate(
        self, signals: Signals, step: float | None = None, spans: Sequence[slice] | None = None
    ) -> tuple[Array, Array]:
        """Free runs side by side.

        Args:
            signals: torque, channels, and of the motion what came before each free run: its first rate and heading, and
                of a memory the water that an earlier turn set in motion.
            step: of the integration [s], rounded to whole grid steps; T_c/STEPS if not given.
            spans: of the grid, each with what came before it in its run; all runs as a whole if not given.

        Returns:
            indices into the grid of `signals.pieces(spans)` and the simulated rate there [rad/s].
        """
        return simulate([self], signals, step or self.scale / STEPS, [signals.runs() if spans is None else spans])

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
            data["sigma"], data["block"], data["scale"], (low, high),
        )  # fmt: skip


def simulate(
    models: Sequence[TracedModel], signals: Signals, step: float, spans: Sequence[Sequence[slice]]
) -> tuple[Array, Array]:
    """Free runs of several models side by side, each over spans of its own; else as `TracedModel.simulate`.

    Returns:
        indices into the grid of `signals.pieces` of all spans, one after the other, and the simulated rate there.
    """
    plan = Plan(models, signals, spans, max(round(step / signals.step), 1))
    rate, heading, water = plan.rate, plan.heading, plan.water
    trace = np.empty((plan.length + 1, rate.size))
    trace[0] = rate
    rubbed = 0.5 * plan.step * plan.friction
    has_friction = bool(rubbed.any())
    nudge = 1e-4 * plan.limit / FASTEST
    pace = plan.step / nudge
    for k in range(plan.length):
        if has_friction:
            rate = rub(rate, rubbed, plan.creep)
        push, there = plan.acceleration(k, rate, nudge, heading, water)
        z = pace * (there - push)
        z = np.minimum(np.where(np.abs(z) < 1e-6, 1e-6, z), 50.0)
        new = rate + plan.step * np.expm1(z) / z * push
        new = np.minimum(np.maximum(new, -plan.limit), plan.limit)  # np.clip takes ten times as long on so few
        if has_friction:
            new = rub(new, rubbed, plan.creep)
        mean = 0.5 * (rate + new)
        heading = heading + plan.step * mean
        water = plan.moved(water, mean)
        rate = new
        trace[k + 1] = rate
    index, column, row = plan.index()
    return index, trace[row, column]
