"""A set of effects settled on the data: damping, coefficients and inner parameters fitted together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.effects import Effect, Term
from incsvr.tracing.run import Array
from incsvr.tracing.weak.damping import SPLINE
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.refining import refined
from incsvr.tracing.weak.views import Views
from incsvr.tracing.weak.whitening import Fit, fit, without_jump_noise

ALIGNMENT = 30.0
"""What a delay within the sampling pays in 2 ℓ: any effect that explains as much is the better explanation."""

TIMED = 2
"""Passes in which the jumps of the command are taken as on time: where a new effect is far from its value, what it does
there would pass for the noise of their instants."""

SAMPLING = 0.7
"""Of a sample period: half of one lies between a torque that is held from stamp to stamp and a linear one."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of effects as fitted to a problem.

    Attributes:
        terms: the effects with their values, in the order in which they were added.
        effects: the same effects of the catalogue.
        fit: of the whole regression: damping first, then the columns of each term.
        columns: (n_b, p) of that regression.
        jacobian: (2, n_b, p) how they answer the noise of their own block, for `whitening.fit`.
        gyro_noise_correction: (p,) and how they follow the gyro's.
        losses: (n,) the torque that each term takes [N m].
        criterion: 2 ℓ − Σ (df ln n + 2 ln looks): what hypotheses are compared by.
        position: first column of each term.
        offsets: (n_b,) of each term: what its columns, being tangents, leave of its loss [N m].
    """

    terms: tuple[Term, ...]
    effects: tuple[Effect, ...]
    fit: Fit
    columns: Array
    jacobian: Array
    gyro_noise_correction: Array
    losses: tuple[Array, ...]
    criterion: float
    position: tuple[int, ...]
    offsets: tuple[Array, ...]

    def names(self) -> tuple[str, ...]:
        return tuple(term.effect for term in self.terms)

    def values(self) -> list[tuple[Effect, tuple[float, ...], tuple[float, ...]]]:
        """Its effects as they were settled, for `settle`."""
        return [(e, t.inner, t.coefficients) for e, t in zip(self.effects, self.terms, strict=True)]


def views(problem: Problem, hypothesis: Hypothesis) -> Views:
    """The signals as a further effect sees them under a hypothesis."""
    known = zip(hypothesis.effects, hypothesis.losses, hypothesis.terms, strict=True)
    return Views(problem, hypothesis.fit, [(e, loss, term.coefficients) for e, loss, term in known])


def nothing(problem: Problem) -> Hypothesis:
    """The declared model with its learned damping."""
    columns = problem.coarse
    fitted = fit(problem.y, columns, problem.blocks, rounds=6, jacobian=problem.jacobian, spline=SPLINE)
    none = np.zeros(columns.shape[1])
    return Hypothesis((), (), fitted, columns, problem.jacobian, none, (), 2.0 * fitted.log_likelihood, (), ())


def below_sampling(term: Term, problem: Problem) -> bool:
    """A delay or lag within most of a sample period is how the streams were sampled, not how the thrust acts."""
    return term.effect in ("torque_delay", "torque_lag") and abs(term.coefficients[0]) < SAMPLING * problem.resolution


def price(effect: Effect, columns: int, problem: Problem) -> float:
    """What an effect pays in 2 ℓ for its freedom (BIC) and for the looks of the search over its inner parameter."""
    freedom = columns + len(effect.sought)
    return freedom * float(np.log(len(problem.blocks))) + 2.0 * float(np.log(effect.looks))


def noise_gain(problem: Problem, fitted: Fit, effect: Effect, term: Term) -> float:
    """Change of ln of the residual's noise by an effect that filters the torque's: no evidence. 0 or negative."""
    passed = effect.passed(term, problem.signals)
    if passed is None:
        return 0.0
    # of what is left behind the filter no more is the torque's noise than its fraction: a controller's answer is none
    noise_fraction = problem.signals.torque_noise_fraction
    noisy = np.minimum(
        problem.noisy(fitted), noise_fraction / np.maximum(1.0 - noise_fraction + noise_fraction * passed, 1e-3)
    )
    return -float(np.mean(np.log1p((1.0 - passed) * noisy)))


def settle(
    problem: Problem,
    terms: Sequence[tuple[Effect, tuple[float, ...], tuple[float, ...]]],
    start: Hypothesis,
    refine: frozenset[str] = frozenset(),
    passes: int = 4,
) -> Hypothesis:
    """Fit damping and effects together until thrust as seen from the rate side agrees with itself.

    Args:
        terms: (effect, inner parameters, coefficients so far or empty) of each effect.
        start: where to begin: its damping, its AR and what its terms take.
        refine: keys of the effects whose searched parameter is refined on the way.
    """
    known: Mapping[str, Array] = {e.key: loss for e, loss in zip(start.effects, start.losses, strict=True)}
    effects = [effect for effect, _, _ in terms]
    inner = [i for _, i, _ in terms]
    coefficients = [c for _, _, c in terms]
    zero = np.zeros(len(problem.signals))
    losses = [known.get(effect.key, zero) for effect in effects]
    fitted, before = start.fit, -np.inf
    new = any(effect.key not in known for effect in effects)
    if new:
        # What a new effect explains is in the residual, its tones are in the AR, and what it does at the command's
        # jumps passes for their noise: none of them tells the noise.
        fitted = replace(without_jump_noise(fitted), ar=np.zeros(3), residual=np.zeros(len(problem.blocks)))
    columns = problem.coarse
    jacobian = still = problem.jacobian
    gyro_noise_correction = np.zeros(columns.shape[1])
    position: list[int] = []
    offsets: list[Array] = []
    answers = [still] * len(effects)
    for turn in range(passes):
        seen = Views(
            problem, fitted, [(e, x, c or (0.0,)) for e, x, c in zip(effects, losses, coefficients, strict=True)]
        )
        fine = [e.columns(seen.of(e), i, c) for e, i, c in zip(effects, inner, coefficients, strict=True)]
        coarse = [_mean(problem, e, f) for e, f in zip(effects, fine, strict=True)]
        fine_offsets = [e.offset(seen.of(e), c, f) for e, c, f in zip(effects, coefficients, fine, strict=True)]
        offsets = [
            np.zeros(len(problem.blocks)) if offset is None else problem.blocks.mean(offset) for offset in fine_offsets
        ]
        y = problem.y - sum(offsets, np.zeros(len(problem.blocks)))
        base = problem.coarse
        sought = [turn in (1, 2) and bool(effect.sought) and effect.key in refine for effect in effects]
        for k, effect in enumerate(effects):
            # what answers hardly hangs on an effect's size; but a tangent's does, and one that lost the noise of jumps;
            # where its parameter is sought it is told after that
            hangs = effect.acts == "thrust" and (effect.curved or fitted.jump_noise > 0.0)
            if (turn < 2 or hangs) and not sought[k]:
                answers[k] = seen.jacobian(effect, inner[k], coefficients[k], coarse[k])
        for k, effect in enumerate(effects):
            if sought[k]:
                for place in effect.sought:
                    inner[k] = refined(
                        y, problem.blocks, effect, seen.of(effect), inner[k], coefficients[k], [base, *coarse],
                        [still, *answers], k + 1, fitted, 8 if turn == 1 and passes > 2 else 12, place,
                    )  # fmt: skip
                fine[k] = effect.columns(seen.of(effect), inner[k], coefficients[k])
                coarse[k] = _mean(problem, effect, fine[k])
                answers[k] = seen.jacobian(effect, inner[k], coefficients[k], coarse[k])
        columns = side_by_side([base, *coarse])
        jacobian = side_by_side([still, *answers])
        none = np.zeros(base.shape[1])
        gyro_noise_correction = np.concatenate(
            [none, *(seen.gyro_noise_correction(e, x) for e, x in zip(effects, coarse, strict=True))]
        )
        blocks = problem.blocks.on_time if new and turn < TIMED else problem.blocks
        fitted = fit(
            y,
            columns,
            blocks,
            fitted,
            rounds=2,
            jacobian=jacobian,
            gyro_noise_correction=gyro_noise_correction,
            spline=SPLINE,
        )
        position, at = [], problem.coarse.shape[1]
        for k, part in enumerate(coarse):
            position.append(at)
            coefficients[k] = tuple(float(v) for v in fitted.theta[at : at + part.shape[1]])
            if effects[k].acts == "inertia":
                coefficients[k] = (max(coefficients[k][0], -0.9 * problem.signals.inertia),)
            offset = fine_offsets[k]
            losses[k] = fine[k] @ fitted.theta[at : at + part.shape[1]] + (0.0 if offset is None else offset)
            at += part.shape[1]
        if new and turn < TIMED:
            continue
        settled = abs(fitted.log_likelihood - before) < 0.05 and turn > 1
        if settled or (
            turn > 0
            and not any(e.curved or e.searched for e in effects)
            and problem.signals.torque_noise_fraction >= 1.0
        ):
            break
        before = fitted.log_likelihood
    found = tuple(Term(e.name, e.variant, c, i) for e, c, i in zip(effects, coefficients, inner, strict=True))
    penalty = sum(price(e, len(c), problem) for e, c in zip(effects, coefficients, strict=True))
    penalty += ALIGNMENT * sum(below_sampling(term, problem) for term in found)
    penalty -= len(problem.blocks) * sum(noise_gain(problem, fitted, e, t) for e, t in zip(effects, found, strict=True))
    criterion = 2.0 * fitted.log_likelihood - penalty
    return Hypothesis(
        found, tuple(effects), fitted, columns, jacobian, gyro_noise_correction, tuple(losses), criterion,
        tuple(position), tuple(offsets),
    )  # fmt: skip


def resettled(problem: Problem, hypothesis: Hypothesis) -> Hypothesis:
    """The same effects, settled on other equations."""
    base = nothing(problem)
    return settle(problem, hypothesis.values(), base) if hypothesis.terms else base


def side_by_side(parts: Sequence[Array]) -> Array:
    """(…, p) their columns in one array, the blocks of a column one after the other: sums run along these."""
    joined: Array = np.moveaxis(np.concatenate([np.moveaxis(part, -1, 0) for part in parts]), 0, -1)
    return joined


def _mean(problem: Problem, effect: Effect, fine: Array) -> Array:
    """Block means; the acceleration's is Δr/T_b, as in y."""
    if effect.acts == "inertia":
        return problem.blocks.slope(problem.signals.ends)[:, None]
    return problem.blocks.mean(fine)


def left_over(problem: Problem, hypothesis: Hypothesis, passes: int = 3) -> tuple[Array, dict[str, Array]]:
    """What a fitted hypothesis leaves of other blocks than it was fitted to, nothing fitted again.

    Returns:
        (n_b,) residual with the measured motion [N m], and the torque that each effect takes, (n,) each.
    """
    theta = hypothesis.fit.theta
    base = problem.y - problem.coarse @ theta[: problem.coarse.shape[1]]
    losses = [np.zeros(len(problem.signals)) for _ in hypothesis.terms]
    residual = base
    known = list(zip(hypothesis.effects, hypothesis.terms, strict=True))
    for _ in range(passes if known else 0):
        fitted = replace(hypothesis.fit, residual=residual)
        terms = [(e, x, t.coefficients) for (e, t), x in zip(known, losses, strict=True)]
        seen = Views(problem, fitted, terms)
        residual = base
        for k, (effect, term) in enumerate(known):
            columns = effect.columns(seen.of(effect), term.inner, term.coefficients)
            offset = effect.offset(seen.of(effect), term.coefficients, columns)
            losses[k] = columns @ np.array(term.coefficients) + (0.0 if offset is None else offset)
            if effect.acts == "inertia":
                residual = residual - term.coefficients[0] * problem.blocks.slope(problem.signals.ends)
            else:
                residual = residual - problem.blocks.mean(losses[k])
    return residual, {term.effect: loss for (_, term), loss in zip(known, losses, strict=True)}
