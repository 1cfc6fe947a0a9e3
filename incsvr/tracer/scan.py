"""The scan: which effects promise to explain what a hypothesis leaves, by a score test of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.effects import Effect
from incsvr.tracer.hypothesis import Hypothesis, nothing, price, settle, views
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array
from incsvr.tracer.whitening import whiten

TOLD = 1e-9
"""Of a column's square: less than that is left where it is but a sum of others."""


@dataclass(frozen=True, slots=True)
class Lead:
    """A candidate that a scan holds for promising: its best inner parameters, its 2 Δℓ and that less its price."""

    effect: Effect
    inner: tuple[float, ...]
    score: float
    gain: float = 0.0


def scan(
    problem: Problem,
    base: Hypothesis,
    effects: Iterable[Effect],
    coloured: bool = True,
    known: dict[tuple[str, tuple[float, ...]], Array] | None = None,
) -> list[Lead]:
    """Score test of every effect and every start of its inner parameter, best first.

    What the columns gain in 2 ℓ over `base`, its AR and weights held; with `coloured` off, as if the residual were
    white (an AR estimated on a residual that still holds an effect hides it). `known` holds the block means of columns
    from one scan over the same base to the next.
    """
    ar = base.fit.ar if coloured else np.zeros(3)
    root = np.sqrt(base.fit.weight)[:, None]
    q, r = np.linalg.qr(root * whiten(base.columns, ar, problem.blocks))
    z = root[:, 0] * whiten(base.fit.residual, ar, problem.blocks)
    variance = float(z @ z) / z.size
    pulled = variance if coloured else 0.0
    stretch = np.maximum(1.0 + base.turned @ base.fit.theta, 0.1)[:, :, None]

    def pull_of(turned: Array) -> Array:
        """(p,) derivative of the Jacobian by the coefficients."""
        grown, held = (turned / stretch)[:, problem.blocks.whole].sum(axis=1)
        return np.asarray(grown - held)

    def gained(effect: Effect, columns: Array, own: Array) -> float:
        c = root * whiten(columns, ar, problem.blocks)
        size = np.einsum("ij,ij->j", c, c)
        along = q.T @ c
        c = c - q @ along
        # what the Jacobian adds to the score, less what the base's own columns would take of it
        pull = pull_of(own) - np.linalg.solve(upright, along).T @ turned
        return _gained(effect, c.T @ c, c.T @ z + pulled * pull, size)

    turned = pull_of(base.turned)
    upright = r + 1e-9 * (float(np.max(np.abs(np.diag(r)))) + 1e-300) * np.eye(r.shape[0])
    seen = views(problem, base)
    known = {} if known is None else known
    leads = []
    for effect in effects:
        s = seen.of(effect)
        best: tuple[float, tuple[float, ...], Array] | None = None
        for inner in effect.starts(s):
            if (effect.key, inner) not in known:
                known[effect.key, inner] = problem.blocks.mean(effect.columns(s, inner, ()))
            columns = known[effect.key, inner]
            if not np.all(np.isfinite(columns)):
                continue
            c = root * whiten(columns, ar, problem.blocks)
            size = np.einsum("ij,ij->j", c, c)
            c = c - q @ (q.T @ c)
            if not np.all(np.diag(c.T @ c)[: effect.core] > TOLD * size[: effect.core] + 1e-300):
                continue
            # of an effect whose coefficient is one by nature what that one gains
            fits = float(c[:, 0] @ (2.0 * z - c[:, 0])) if effect.whole else _gained(effect, c.T @ c, c.T @ z, size)
            if best is None or fits > best[0]:
                best = fits, inner, columns
        if best is None:
            continue
        _, inner, columns = best
        own = seen.turned(effect, inner, (), columns)
        gain = gained(effect, columns, own)
        gain = -z.size * float(np.log(max(1.0 - gain / (z.size * variance), 1e-9)))
        leads.append(Lead(effect, inner, gain - price(effect, effect.core, problem), gain))
    return sorted(leads, key=lambda lead: -lead.score)


def _gained(effect: Effect, normal: Array, score: Array, size: Array) -> float:
    """Squares that the columns explain, less those that merely place the effect's zero."""
    told = np.diag(normal) > TOLD * size + 1e-300
    normal, score = normal[np.ix_(told, told)], score[told]  # without an offset that another effect's column already is
    return _explained(normal, score) - _explained(normal[effect.core :, effect.core :], score[effect.core :])


def _explained(normal: Array, score: Array) -> float:
    if score.size == 0:
        return 0.0
    return float(score @ np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), score))


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


def excepting(problem: Problem, base: Hypothesis, out: Sequence[int]) -> Hypothesis:
    """`base` with several effects taken out."""
    for k in sorted(out, reverse=True):
        base = without(problem, base, k)
    return base


def best_leads(problem: Problem, base: Hypothesis, effects: Sequence[Effect], width: int) -> list[Lead]:
    """The `width` best of the coloured scan and a third as many of the white one, once each."""
    known: dict[tuple[str, tuple[float, ...]], Array] = {}
    first = _spread(scan(problem, base, effects, known=known), width)
    second = _spread(scan(problem, base, effects, coloured=False, known=known), (width + 2) // 3)
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
