"""The search: which set of effects explains the recordings, no more and no less."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect
from incsvr.tracer.hypothesis import Hypothesis, below_sampling, nothing, price, settle, views
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array
from incsvr.tracer.whitening import whiten

THRESHOLD = 16.0
"""Least gain of the criterion by which an effect is added."""

CONTRIBUTION = 0.2
"""Least deviation of what an effect alone explains, in deviations of the block residual."""

SHAPE = 0.25
"""Of the largest effect's contribution: the catalogue knows no effect's true shape more closely than that.

What is left of a wrong shape is a function of the motion. It can pass for another effect of the motion, and must be
outdone by one; a bias, a drift or an extra channel is none.
"""

LEADERS = 8
"""How many of the first scan's effects are tried in pairs."""


@dataclass(frozen=True, slots=True)
class Lead:
    """A candidate that a scan holds for promising: its best inner parameters, its 2 Δℓ and that less its price."""

    effect: Effect
    inner: tuple[float, ...]
    score: float
    gain: float = 0.0


def scan(problem: Problem, base: Hypothesis, effects: Iterable[Effect], coloured: bool = True) -> list[Lead]:
    """Score test of every effect and every start of its inner parameter, best first.

    What the columns gain in 2 ℓ over `base`, its AR and weights held; with `coloured` off, as if the residual were
    white (an AR estimated on a residual that still holds an effect hides it).
    """
    ar = base.fit.ar if coloured else np.zeros(3)
    root = np.sqrt(base.fit.weight)[:, None]
    q, _ = np.linalg.qr(root * whiten(base.columns, ar, problem.blocks))
    z = root[:, 0] * whiten(base.fit.residual, ar, problem.blocks)
    z = z - q @ (q.T @ z)
    variance = float(z @ z) / z.size
    seen = views(problem, base)
    leads = []
    for effect in effects:
        best: Lead | None = None
        s = seen.of(effect)
        for inner in effect.starts(s):
            columns = problem.blocks.mean(effect.columns(s, inner, ()))
            if not np.all(np.isfinite(columns)):
                continue
            c = root * whiten(columns, ar, problem.blocks)
            size = np.einsum("ij,ij->j", c, c)
            c = c - q @ (q.T @ c)
            normal = c.T @ c
            if np.any(np.diag(normal) <= 1e-9 * size + 1e-300):
                continue
            gain = _explained(c, z) - _explained(c[:, effect.core :], z)  # what merely places its zero does not count
            gain = -z.size * float(np.log(max(1.0 - gain / (z.size * variance), 1e-9)))
            score = gain - price(effect, effect.core, problem)
            if best is None or score > best.score:
                best = Lead(effect, inner, score, gain)
        if best is not None:
            leads.append(best)
    return sorted(leads, key=lambda lead: -lead.score)


def _explained(columns: Array, z: Array) -> float:
    if columns.shape[1] == 0:
        return 0.0
    normal, right = columns.T @ columns, columns.T @ z
    return float(right @ np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), right))


def with_lead(problem: Problem, base: Hypothesis, lead: Lead) -> Hypothesis:
    """`base` with one more effect, settled."""
    terms = [(e, t.inner, t.coefficients) for e, t in zip(base.effects, base.terms, strict=True)]
    return settle(problem, [*terms, (lead.effect, lead.inner, ())], base, frozenset({lead.effect.key}))


def without(problem: Problem, base: Hypothesis, k: int) -> Hypothesis:
    """`base` with its k-th effect taken out, settled."""
    if len(base.terms) == 1:
        return nothing(problem)
    terms = [(e, t.inner, t.coefficients) for e, t in zip(base.effects, base.terms, strict=True)]
    return settle(problem, [*terms[:k], *terms[k + 1 :]], base, passes=3)


def best_leads(problem: Problem, base: Hypothesis, effects: Sequence[Effect], width: int) -> list[Lead]:
    """The `width` best of the coloured scan and of the white one, once each."""
    first = _spread(scan(problem, base, effects), width)
    second = _spread(scan(problem, base, effects, coloured=False), width)
    # an AR that has swallowed a tone hides its period: the same effect may come with another inner parameter
    keys = {(lead.effect.key, lead.inner) for lead in first}
    return first + [lead for lead in second if (lead.effect.key, lead.inner) not in keys]


def _spread(leads: list[Lead], width: int) -> list[Lead]:
    """The best, but of the many channels' modulations and couplings no more than half."""
    kept: list[Lead] = []
    for lead in leads:
        of_channels = sum(bool(other.effect.channels) for other in kept)
        if len(kept) < width and not (lead.effect.channels and of_channels >= (width + 1) // 2):
            kept.append(lead)
    return kept


def sound(problem: Problem, hypothesis: Hypothesis) -> str:
    """Why a hypothesis cannot be accepted (physics, size, a residual that rose); empty if it can."""
    seen = views(problem, hypothesis)
    alone = [unique_share(problem, hypothesis, k) for k in range(len(hypothesis.terms))]
    for k, (effect, term) in enumerate(zip(hypothesis.effects, hypothesis.terms, strict=True)):
        if not np.all(np.isfinite(term.coefficients)):
            return f"{term.effect}: no finite fit"
        reason = effect.implausible(term, seen.of(effect))
        if reason:
            return f"{term.effect}: {reason}"
        if alone[k] < CONTRIBUTION:
            return f"{term.effect}: what it alone explains is lost in the noise"
        if effect.of_phase and alone[k] < SHAPE * max(alone):
            return f"{term.effect}: what it alone explains is within the shape error of a larger effect"
    if problem.one_sine:
        # rate, heading, thrust and their derivatives are functions of one phase: any two fit the shape error of one
        terms = zip(hypothesis.effects, hypothesis.terms, strict=True)
        phased = [t.effect for e, t in terms if e.of_phase and not below_sampling(t, problem)]
        if len(phased) > 1:
            return f"{phased[-1]}: a command of one sine cannot tell two effects of the motion apart"
    values = {term.effect: term.coefficients[0] for term in hypothesis.terms}
    if values.get("torque_delay", 0.0) < 0.0 < values.get("torque_lag", 0.0):
        return "torque_lag: a lag against a negative delay is no effect but a shape"
    return ""


def unique_share(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    """Deviation of what the k-th effect alone explains, in (robust) deviations of the block residual."""
    core = _core(hypothesis, k)
    rest = np.delete(hypothesis.columns, core, axis=1)
    part = hypothesis.columns[:, core] @ hypothesis.fit.theta[core] + hypothesis.offsets[k]
    alone = part - rest @ np.linalg.lstsq(rest, part, rcond=1e-10)[0]
    residual = hypothesis.fit.residual
    deviation = min(1.4826 * float(np.median(np.abs(residual - np.median(residual)))), float(np.std(residual)))
    return float(np.std(alone)) / max(deviation, 1e-300)


def _core(hypothesis: Hypothesis, k: int) -> NDArray[np.intp]:
    at = hypothesis.position[k]
    return np.arange(at, at + hypothesis.effects[k].core)


def worth(hypothesis: Hypothesis) -> float:
    """What hypotheses compete by: every named effect must have brought the threshold."""
    return hypothesis.criterion - THRESHOLD * len(hypothesis.terms)


def _rose(grown: Hypothesis, base: Hypothesis) -> bool:
    """Whether the raw residual rose, its level apart (that may be the next effect): an AR near a unit root hides it."""

    def spread(h: Hypothesis) -> float:
        return float(np.median(np.abs(h.torque_residual - np.median(h.torque_residual))))

    return spread(grown) > 1.02 * spread(base)


class FreeRun(Protocol):
    """The judge of every step."""

    def __call__(self, hypothesis: Hypothesis) -> float:
        """Free-run error on unseen data [rad/s]."""
        ...

    def better(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether the free run of `new` is better by more than chance would have it."""
        ...


@dataclass
class Search:
    """One search; it remembers what the free run refused.

    Attributes:
        problem: the equations.
        effects: what may be added.
        free_run: the judge of every step: what improves the equation alone is not added.
        closed_loop: whether the torque is feedback of the yaw rate.
        most: effects that may stand at once.
        refused: effect → why it was not added though the equation asked for it.
    """

    problem: Problem
    effects: Sequence[Effect]
    free_run: FreeRun
    closed_loop: bool = False
    most: int = 5
    refused: dict[str, str] = field(default_factory=dict)

    def run(self) -> Hypothesis:
        """Add, drop and swap effects until nothing gains; then try all pairs of the first leaders."""
        base = nothing(self.problem)
        singles = [with_lead(self.problem, base, lead) for lead in best_leads(self.problem, base, self.effects, 8)]
        leaders = self._ranked(h for h in singles if worth(h) > worth(base))
        first = next((h for h in leaders if self._accepts(h, base)), base)
        best = self._pairs(self._climb(first), leaders[:LEADERS])
        best = self._clean(best)
        for name in best.names():
            self.refused.pop(name, None)
        return best

    def _ranked(self, hypotheses: Iterable[Hypothesis]) -> list[Hypothesis]:
        """Best first: by the equation; where the torque answers the disturbances by the free run."""
        if self.closed_loop:
            return sorted((h for h in hypotheses if not sound(self.problem, h)), key=self.free_run)
        return sorted(hypotheses, key=worth, reverse=True)

    def _accepts(self, new: Hypothesis, old: Hypothesis) -> bool:
        """Whether physics, the raw residual and the free run all agree to a step that the equation wants."""
        if sound(self.problem, new) or _rose(new, old):
            return False
        if self.free_run.better(new, old):
            return True
        for name in set(new.names()) - set(old.names()):
            self.refused[name] = self._reason(new, old)
        return False

    def _reason(self, new: Hypothesis, old: Hypothesis) -> str:
        return (
            "it improves the torque equation, but the free run on unseen data gets no better: "
            f"{self.free_run(old):.3g} rad/s without it, {self.free_run(new):.3g} rad/s with it"
        )

    def _climb(self, base: Hypothesis) -> Hypothesis:
        while True:
            grown = self._grow(base) if len(base.terms) < self.most else base
            changed = self._swap(self._clean(grown))
            if worth(changed) <= worth(base) + 1e-6:
                return base
            base = changed
            if len(base.terms) >= self.most:
                return base

    def _grow(self, base: Hypothesis) -> Hypothesis:
        taken = set(base.names())
        leads = best_leads(self.problem, base, [e for e in self.effects if e.name not in taken], 4)
        tried = [with_lead(self.problem, base, lead) for lead in leads if lead.score > -20.0]
        wanted = self._ranked(h for h in tried if worth(h) > worth(base))
        return next((h for h in wanted if self._accepts(h, base)), base)

    def _clean(self, base: Hypothesis) -> Hypothesis:
        """Drop effects that others made idle, in the equation or in the free run."""
        while base.terms:
            less = [without(self.problem, base, k) for k in range(len(base.terms))]
            less = [h for h in less if not (h.terms and sound(self.problem, h))]
            idle = [h for h in less if worth(h) >= worth(base) or not self.free_run.better(base, h)]
            if not idle:
                return base
            best = max(idle, key=worth)
            if worth(best) < worth(base):
                for name in set(base.names()) - set(best.names()):
                    self.refused[name] = self._reason(base, best)
            base = best
        return base

    def _swap(self, base: Hypothesis) -> Hypothesis:
        """Replace one effect by a rival that explains more in the presence of the others."""
        for k in range(len(base.terms)):
            less = without(self.problem, base, k)
            taken = set(less.names())
            rivals = [e for e in self.effects if e.name not in taken and e.key != base.effects[k].key]
            for lead in best_leads(self.problem, less, rivals, 3):
                swapped = with_lead(self.problem, less, lead)
                wanted = worth(swapped) > worth(base) + 1.0 and not self.free_run.better(base, swapped)
                if wanted and self._accepts(swapped, less):
                    return self._swap(swapped)
        return base

    def _pairs(self, best: Hypothesis, leaders: Sequence[Hypothesis]) -> Hypothesis:
        """Two effects that need each other are found by no single step."""
        champion = best
        for one, two in combinations(leaders, 2):
            if one.names() == two.names():
                continue
            terms = [(h.effects[0], h.terms[0].inner, h.terms[0].coefficients) for h in (one, two)]
            both = settle(self.problem, terms, one, frozenset(e.key for e, _, _ in terms), passes=5)
            if worth(both) > worth(champion) + 2.0 and self._accepts(both, champion):
                champion = both
        return best if champion is best else self._climb(champion)
