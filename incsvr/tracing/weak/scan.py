"""The scan: which effects promise to explain what a hypothesis leaves, by a score test of each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect, Signals, Term
from incsvr.tracing.run import Array
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing, price, settle, views
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.views import Views
from incsvr.tracing.weak.whitening import whiten, without_jump_noise

SWALLOWED = 2
"""Effects beside which an AR has nothing left to swallow that would be worth a second scan."""

INDEPENDENT = 1e-9
"""Of a column's square: less than that is left where it is but a sum of others."""


@dataclass(frozen=True, slots=True)
class Lead:
    """A candidate that a scan holds for promising.

    Attributes:
        effect: the candidate.
        inner: its best inner parameters.
        score: its 2 Δℓ less its price.
        gain: its 2 Δℓ.
        promised: the coefficients that would give as much.
        hidden: whether it is what explains most, were the noise white: what an AR has swallowed.
    """

    effect: Effect
    inner: tuple[float, ...]
    score: float
    gain: float
    promised: tuple[float, ...]
    hidden: bool = False

    def doubtful(self, seen: Views) -> bool:
        """Whether physics forbids the promised coefficients."""
        term = Term(self.effect.name, self.effect.variant, self.promised, self.inner)
        return bool(self.effect.implausible(term, seen.of(self.effect)))


@dataclass(frozen=True, slots=True)
class Known:
    """What two scans over one base share.

    Attributes:
        seen: the signals beside the base.
        columns: of each effect its starts and the block means of their columns, side by side.
    """

    seen: Views
    columns: dict[str, tuple[list[tuple[float, ...]], Array]] = field(default_factory=dict)


def scan(
    problem: Problem,
    base: Hypothesis,
    effects: Iterable[Effect],
    coloured: bool = True,
    known: Known | None = None,
) -> list[Lead]:
    """Score test of every effect and every start of its inner parameter, best first.

    What the columns gain in 2 ℓ over `base`, its AR and weights held; with `coloured` off, as if the residual were
    white and no larger where the command jumps (an AR estimated on a residual that still holds an effect hides it).
    `known` goes from one scan over the same base to the next.
    """
    ar = base.fit.ar if coloured else np.zeros(3)
    root = np.sqrt(base.fit.weight if coloured else without_jump_noise(base.fit).weight)[:, None]
    q, r = np.linalg.qr(root * whiten(base.columns, ar, problem.blocks))
    z = root[:, 0] * whiten(base.fit.residual, ar, problem.blocks)
    variance = float(z @ z) / z.size
    pull = np.zeros((2, len(problem.blocks)))
    pull[:, problem.blocks.with_history] = (
        1.0 / np.maximum(1.0 + base.jacobian @ base.fit.theta, 0.1)[:, problem.blocks.with_history]
    )

    def pull_of(jacobian: Array) -> Array:
        """(p,) derivative of the Jacobian by the coefficients."""
        return np.asarray(pull[0] @ jacobian[0] - pull[1] @ jacobian[1])

    base_pull = pull_of(base.jacobian)
    upright = r + 1e-9 * (float(np.max(np.abs(np.diag(r)))) + 1e-300) * np.eye(r.shape[0])
    known = Known(views(problem, base)) if known is None else known
    seen = known.seen
    leads = []
    for effect in effects:
        if effect.beside and effect.beside not in base.names():
            continue
        if effect.key not in known.columns:
            known.columns[effect.key] = _at_starts(problem, effect, seen.of(effect))
        starts, columns = known.columns[effect.key]
        if not starts:
            continue
        c = root * whiten(columns, ar, problem.blocks)
        size = np.einsum("ij,ij->j", c, c)
        along = q.T @ c
        c -= q @ along
        count = c.shape[1] // len(starts)
        parts = [slice(k, k + count) for k in range(0, c.shape[1], count)]
        fits = [_fits(effect, inner, c[:, part], z, size[part]) for inner, part in zip(starts, parts, strict=True)]
        best = int(np.argmax(fits))
        if fits[best] == -np.inf:
            continue
        inner, part = starts[best], parts[best]
        normal, score = c[:, part].T @ c[:, part], c[:, part].T @ z
        if coloured:  # what the Jacobian adds to the score, less what the base's own columns would take of it
            answers = seen.jacobian(effect, inner, (), columns[:, part])
            score += variance * (pull_of(answers) - np.linalg.solve(upright, along[:, part]).T @ base_pull)
        gain = _gained(effect, normal, score, size[part])
        # a column that is but a sum of others has no coefficient of its own
        kept, promised = _independent(normal, size[part]), np.zeros(count)
        promised[kept] = _solved(normal[np.ix_(kept, kept)], score[kept])
        gain = -z.size * float(np.log(max(1.0 - gain / (z.size * variance), 1e-9)))
        leads.append(Lead(effect, inner, gain - price(effect, effect.core, problem), gain, tuple(promised.tolist())))
    return sorted(leads, key=lambda lead: -lead.score)


def _at_starts(problem: Problem, effect: Effect, s: Signals) -> tuple[list[tuple[float, ...]], Array]:
    """The starts with finite columns, and the block means of these side by side."""
    starts, columns = [], [np.zeros((len(problem.blocks), 0))]
    for inner in effect.starts(s):
        mean = problem.blocks.mean(effect.columns(s, inner, ()))
        if np.all(np.isfinite(mean)):
            starts.append(inner)
            columns.append(mean)
    return starts, np.concatenate(columns, axis=1)


def _fits(effect: Effect, inner: tuple[float, ...], c: Array, z: Array, size: Array) -> float:
    """What a start explains of `z`; of an effect that leaves no choice of its coefficient there what that one explains.

    −inf where its columns are but sums of those that are there.
    """
    normal, score = c.T @ c, c.T @ z
    if not np.all(_independent(normal, size)[: effect.core]):
        return -np.inf
    if effect.fixed_coefficient or effect.secant:
        value = 1.0 if effect.fixed_coefficient else inner[0]
        return float(2.0 * value * score[0] - value**2 * normal[0, 0])
    return _gained(effect, normal, score, size)


def _independent(normal: Array, size: Array) -> NDArray[np.bool_]:
    """(c,) which of the columns are more than sums of those that are there."""
    kept: NDArray[np.bool_] = np.diag(normal) > INDEPENDENT * size + 1e-300
    return kept


def _gained(effect: Effect, normal: Array, score: Array, size: Array) -> float:
    """Squares that the columns explain, less those that merely place the effect's zero."""
    if score.size == 1:
        return float(score[0] ** 2 / normal[0, 0])
    kept = _independent(normal, size)
    normal, score = normal[np.ix_(kept, kept)], score[kept]  # without an offset that another effect's column already is
    return _explained(normal, score) - _explained(normal[effect.core :, effect.core :], score[effect.core :])


def _explained(normal: Array, score: Array) -> float:
    return float(score @ _solved(normal, score)) if score.size else 0.0


def _solved(normal: Array, score: Array) -> Array:
    return np.asarray(np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), score))


def with_lead(problem: Problem, base: Hypothesis, lead: Lead) -> Hypothesis:
    """`base` with one more effect, settled: what one of them took on of the new one, it gives back, so the searched
    parameters of all are found again."""
    terms, refine = base.values(), frozenset(effect.key for effect in (*base.effects, lead.effect))
    return settle(problem, [*terms, (lead.effect, lead.inner, ())], base, refine)


def instead(problem: Problem, base: Hypothesis, out: Sequence[int], lead: Lead) -> Hypothesis:
    """`base` with one effect in the place of others; what stays is settled from where it is."""
    terms = base.values()
    stay = [term for k, term in enumerate(terms) if k not in out]
    return settle(problem, [*stay, (lead.effect, lead.inner, ())], base, frozenset({lead.effect.key}))


def without(problem: Problem, base: Hypothesis, k: int) -> Hypothesis:
    """`base` with its k-th effect taken out, settled."""
    if len(base.terms) == 1:
        return nothing(problem)
    terms = base.values()
    return settle(problem, [*terms[:k], *terms[k + 1 :]], base, passes=3)


def best_leads(problem: Problem, base: Hypothesis, effects: Sequence[Effect], width: int) -> list[Lead]:
    """The `width` best of the coloured scan and a third as many of the white one, once each with the better score.

    An AR that has swallowed a tone hides its period, so that an effect may come with two inner parameters; one that has
    swallowed a constant hides that. In a loop that swings it hides how long a delay is: one that is among the best
    comes with its start by the white scan, too.
    """
    known = Known(views(problem, base))
    first = _spread(scan(problem, base, effects, known=known), width, known.seen)
    white = scan(problem, base, effects, coloured=False, known=known) if len(base.terms) < SWALLOWED else []
    kept = {lead.effect.key for lead in first}
    second = [
        *_spread(white, (width + 2) // 3, known.seen),
        *(lead for lead in white if lead.effect.secant and lead.effect.key in kept),
    ]
    best: dict[tuple[str, tuple[float, ...]], Lead] = {}
    for lead in (*first, *second):
        key = lead.effect.key, lead.inner
        if key not in best or lead.score > best[key].score:
            best[key] = replace(lead, hidden=bool(second) and key == (second[0].effect.key, second[0].inner))
    return list(best.values())


def _spread(leads: list[Lead], width: int, seen: Views) -> list[Lead]:
    """The best, but of the many channels' modulations and couplings no more than half, and a third of those with
    coefficients that physics forbids: what is not there takes many forms."""
    kept: list[Lead] = []
    of_channels = forbidden = 0
    for lead in leads:
        if len(kept) == width:
            break
        if lead.effect.channels and of_channels >= (width + 1) // 2:
            continue
        doubtful = lead.doubtful(seen)
        if doubtful and forbidden >= (width + 2) // 3:
            continue
        kept.append(lead)
        of_channels += bool(lead.effect.channels)
        forbidden += doubtful
    return kept
