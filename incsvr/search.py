"""The search: which set of effects explains the recordings, no more and no less."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect
from incsvr.hypothesis import Hypothesis, nothing, price, settle, views
from incsvr.problem import Problem
from incsvr.run import Array
from incsvr.whitening import whiten

THRESHOLD = 16.0
"""Least gain of the criterion by which an effect is added."""

CONTRIBUTION = 0.2
"""Least deviation of what an effect alone explains, in deviations of the block residual."""

SHAPE = 0.15
"""Of the largest effect's contribution: the catalogue knows no effect's true shape more closely than that."""

LEADERS = 6
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
    keys = {lead.effect.key for lead in first}
    return first + [lead for lead in second if lead.effect.key not in keys]


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
        if alone[k] < SHAPE * max(alone):
            return f"{term.effect}: what it alone explains is within the shape error of a larger effect"
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


def search(problem: Problem, effects: Sequence[Effect], most: int = 5) -> Hypothesis:
    """Add, drop and swap effects until nothing gains; then try all pairs of the first leaders."""
    base = nothing(problem)
    singles = [with_lead(problem, base, lead) for lead in best_leads(problem, base, effects, 8)]
    leaders = sorted((h for h in singles if worth(h) > worth(base)), key=worth, reverse=True)
    usable = (h for h in leaders if not _rose(h, base) and not sound(problem, h))
    best = _climb(problem, effects, next(usable, base), most)
    if leaders:
        best = _pairs(problem, effects, best, leaders[:LEADERS], most)
    return _clean(problem, best)


def _climb(problem: Problem, effects: Sequence[Effect], base: Hypothesis, most: int) -> Hypothesis:
    while True:
        grown = _grow(problem, effects, base) if len(base.terms) < most else base
        changed = _swap(problem, effects, _clean(problem, grown))
        if worth(changed) <= worth(base) + 1e-6 or len(changed.terms) >= most:
            return max(base, changed, key=worth)
        base = changed


def _grow(problem: Problem, effects: Sequence[Effect], base: Hypothesis) -> Hypothesis:
    taken = set(base.names())
    open_ = [e for e in effects if e.name not in taken]
    tried = [with_lead(problem, base, lead) for lead in best_leads(problem, base, open_, 4) if lead.score > -20.0]
    for grown in sorted(tried, key=worth, reverse=True):
        if worth(grown) <= worth(base):
            break
        if not _rose(grown, base) and not sound(problem, grown):
            return grown
    return base


def _rose(grown: Hypothesis, base: Hypothesis) -> bool:
    """Whether the raw residual rose: an AR near a unit root can hide that."""
    return float(np.median(np.abs(grown.fit.residual))) > 1.02 * float(np.median(np.abs(base.fit.residual)))


def _clean(problem: Problem, base: Hypothesis) -> Hypothesis:
    """Drop effects that others made idle."""
    while base.terms:
        less = max((without(problem, base, k) for k in range(len(base.terms))), key=worth)
        if worth(less) < worth(base):
            return base
        base = less
    return base


def _swap(problem: Problem, effects: Sequence[Effect], base: Hypothesis) -> Hypothesis:
    """Replace one effect by a rival that explains more in the presence of the others."""
    for k in range(len(base.terms)):
        less = without(problem, base, k)
        taken = set(less.names())
        rivals = [e for e in effects if e.name not in taken and e.key != base.effects[k].key]
        for lead in best_leads(problem, less, rivals, 3):
            swapped = with_lead(problem, less, lead)
            if worth(swapped) > worth(base) + 1.0 and not sound(problem, swapped):
                return _swap(problem, effects, swapped)
    return base


def _pairs(
    problem: Problem, effects: Sequence[Effect], best: Hypothesis, leaders: Sequence[Hypothesis], most: int
) -> Hypothesis:
    """Two effects that need each other are found by no single step."""
    champion = best
    for one, two in combinations(leaders, 2):
        if one.names() == two.names():
            continue
        terms = [(h.effects[0], h.terms[0].inner, h.terms[0].coefficients) for h in (one, two)]
        both = settle(problem, terms, one, frozenset(e.key for e, _, _ in terms), passes=5)
        if worth(both) > worth(champion) + 2.0 and not sound(problem, both):
            champion = both
    return best if champion is best else _climb(problem, effects, champion, most)
