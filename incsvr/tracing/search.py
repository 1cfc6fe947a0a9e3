"""The search: the best candidates are fitted, unseen data decide, and effects that no longer help are removed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect
from incsvr.model_trace.thresholds import (
    ALIKE_EVIDENCE,
    BLOCK_WINDOWS,
    FITTED_LEADS,
    FITTED_PAIRS,
    INNOVATION_EVIDENCE,
    MAX_EFFECTS,
    MIN_BLOCKS,
    RELEVANT_ERROR_SHARE,
    RELEVANT_TORQUE_SHARE,
    STEADY_STANDARD_ERRORS,
    VERY_STEADY_STANDARD_ERRORS,
    WINDOW_EVIDENCE,
)
from incsvr.numerics import Array
from incsvr.tracing.candidates import leads, residual
from incsvr.tracing.dynamics import Dynamics
from incsvr.tracing.errors import Problem, blocks_of
from incsvr.tracing.fit import Fit, fit, held_out_scores
from incsvr.tracing.folds import Difference, difference, folds_of, inflation
from incsvr.tracing.hypothesis import Hypothesis, Part
from incsvr.tracing.response import Response


@dataclass(frozen=True, slots=True)
class FittedHypothesis:
    """A fitted hypothesis, and how well it predicts what it did not see.

    Attributes:
        fitted: to all windows.
        score: (w,) log density of each window by a fit without its fold.
        inflation: as `folds.inflation`.
    """

    fitted: Fit
    score: Array
    inflation: float

    @property
    def hypothesis(self) -> Hypothesis:
        return self.fitted.hypothesis

    @property
    def names(self) -> tuple[str, ...]:
        return self.hypothesis.names

    @property
    def size(self) -> int:
        """The number of free numbers of its effects."""
        return sum(part.vector.size for part in self.hypothesis.parts)


@dataclass(frozen=True, slots=True)
class Search:
    """The state of a search: its problem and the hypotheses tried.

    Attributes:
        problem: the recordings.
        effects: that may be named.
        folds, blocks: (w,) which windows are left out together, and which count as one.
        memory: hypotheses that were tried, by the keys of their effects.
        refused: name of an effect → why it was not added when it was last tried.
        taken_back: names of those that were added until free runs could do without them.
    """

    problem: Problem
    effects: tuple[Effect, ...]
    folds: NDArray[np.intp]
    blocks: NDArray[np.intp]
    memory: dict[tuple[str, ...], FittedHypothesis] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    taken_back: set[str] = field(default_factory=set)

    @staticmethod
    def of(problem: Problem, effects: Sequence[Effect]) -> Search:
        """A search among these effects."""
        cells, windows = problem.cells, problem.windows
        if problem.of_innovations:
            length = cells.signals.scale
        else:
            length = min(BLOCK_WINDOWS, max(windows.first.size / MIN_BLOCKS, 1.0)) * windows.length * cells.step
        return Search(problem, tuple(effects), folds_of(problem), blocks_of(cells, windows, length))

    def tried(self, hypothesis: Hypothesis, beside: Fit | None = None) -> FittedHypothesis:
        """The hypothesis, fitted; `beside` is a fit from whose colour it begins."""
        key = tuple(sorted(part.effect.key for part in hypothesis.parts))
        if key not in self.memory:
            fitted = fit(self.problem, hypothesis, self.problem.colour if beside is None else beside.colour)
            score = held_out_scores(self.problem, fitted, self.folds)
            self.memory[key] = FittedHypothesis(fitted, score, inflation(fitted, self.blocks))
        return self.memory[key]

    def run(self) -> tuple[FittedHypothesis, FittedHypothesis]:
        """Nothing added, and the best that was found."""
        nothing = best = self.tried(self.problem.start)
        for _ in range(2 * MAX_EFFECTS):
            grown = self._grown(best)
            if grown is None or len(grown.names) > MAX_EFFECTS:
                break
            pruned = self._pruned(grown)
            if set(pruned.names) == set(best.names):
                break
            best = pruned
        return nothing, best

    def better(self, new: FittedHypothesis, old: FittedHypothesis) -> Difference:
        """The gain of the new hypothesis in predicting unseen data."""
        return difference(new.score, old.score, self.blocks, new.inflation)

    def alike(self, better: FittedHypothesis, worse: FittedHypothesis) -> bool:
        """Whether unseen data hardly tell the two apart; each free number more asks as much again of the better."""
        more = max(better.size - worse.size, 0)
        return self.better(better, worse).evidence < ALIKE_EVIDENCE * (1 + more)

    def why_not(self, new: FittedHypothesis, old: FittedHypothesis) -> str:
        """The reason against the effects that the new hypothesis adds to the old one; empty if there is none."""
        found = self.better(new, old)
        added = [part for part in new.hypothesis.parts if part.name not in old.names]
        each = INNOVATION_EVIDENCE if self.problem.of_innovations else WINDOW_EVIDENCE
        asked = each * max(len(added), 1) + sum(math.log(part.effect.multiplicity) for part in added)
        if found.evidence < asked or found.deviations < STEADY_STANDARD_ERRORS:
            if self.problem.of_innovations:
                return f"on unseen data its evidence is {found.evidence:.3g} of the {asked:.3g} required"
            if found.deviations < VERY_STEADY_STANDARD_ERRORS:
                return (
                    f"on unseen data its evidence is {found.evidence:.3g} of the {asked:.3g} required, or "
                    f"{found.deviations:.2g} of {VERY_STEADY_STANDARD_ERRORS:g} standard errors"
                )
        if not self.problem.of_innovations and found.share < RELEVANT_ERROR_SHARE:
            return f"it removes {found.share:.2%} of the squared error on unseen data, less than is relevant"
        return self.objection(new)

    def objection(self, tried: FittedHypothesis) -> str:
        """The reason why physics or relevance forbid one of the effects; empty if they do not."""
        return next((why for _, why in self.objections(tried)), "")

    def objections(self, tried: FittedHypothesis) -> Iterator[tuple[int, str]]:
        """Places of effects that physics or relevance forbid, and why."""
        response, cells = tried.fitted.response, self.problem.cells
        d, words = response.dynamics, cells.signals.words
        usual = float(np.mean(cells.signals.torque**2))
        seen = replace(d.seen, acceleration=np.gradient(cells.signals.rate, cells.step), residual=residual(d))
        for k, part in enumerate(tried.hypothesis.parts):
            why = words.fill(part.effect.implausible(part.term, seen) or part.effect.below_relevance(part.term, seen))
            if why:
                yield k, why
            if part.effect.lingers and part.effect.acts == "thrust" and part.vector[0] < cells.resolution:
                yield k, "it is less than a sample of the streams"
            moved = float(np.mean(_moment(response, part) ** 2))
            if part.effect.acts != "inertia" and moved < RELEVANT_TORQUE_SHARE**2 * usual:
                yield (
                    k,
                    f"it changes less than {RELEVANT_TORQUE_SHARE:.0%} of the {words.effort}, which is within the "
                    "error of a thrust table",
                )

    def _grown(self, best: FittedHypothesis) -> FittedHypothesis | None:
        """The hypothesis with the best further candidate; None if none may be named.

        What is not told apart from the best is no worse for having fewer free numbers.
        """
        passed = list[FittedHypothesis]()
        for lead in leads(self.problem, best.fitted, self.effects, FITTED_LEADS, FITTED_PAIRS):
            hypothesis = best.hypothesis
            for part in lead.parts:
                hypothesis = hypothesis.with_part(part)
            new = self.tried(hypothesis, best.fitted)
            stale = [k for k, _ in self.objections(new) if k < len(best.names)]
            if stale:  # what the new one explains had stood for it
                new = self.tried(new.hypothesis.without(stale[0]), best.fitted)
            why = self.why_not(new, best)
            if why:
                self.refused.setdefault(lead.part.name, why)
            else:
                passed.append(new)
        if not passed:
            return None
        most = max(passed, key=lambda each: float(each.score.sum()))
        alike = [each for each in passed if self.alike(most, each)]
        chosen = min([most, *alike], key=lambda each: (each.size, -float(each.score.sum())))
        for name in chosen.names:
            self.refused.pop(name, None)
        return chosen

    def _pruned(self, best: FittedHypothesis) -> FittedHypothesis:
        """Without what does not pay beside the others."""
        while len(best.names) > 1:
            without = [self.tried(best.hypothesis.without(k), best.fitted) for k in range(len(best.names))]
            reasons = [self.why_not(best, rest) for rest in without]
            if not any(reasons):
                return best
            worst = min(
                (k for k, why in enumerate(reasons) if why), key=lambda k: self.better(best, without[k]).evidence
            )
            self.refused[best.names[worst]] = reasons[worst]
            best = without[worst]
        return best


def _moment(response: Response, part: Part) -> Array:
    """(n,) what an effect of the model takes of the torque along the trajectory [N m]."""
    d = response.dynamics
    if part.effect.acts == "thrust":
        others = tuple(each for each in d.model.parts if each is not part)
        without = Dynamics(d.cells, replace(d.model, parts=others))
        return np.asarray((without.thrust - d.thrust)[response.cell])
    if part.effect.acts == "damping":
        factor = part.effect.factor(d.seen, part.term)
        return np.asarray((d.factor * (1.0 - 1.0 / factor))[response.cell] * d.drag(response.rate))
    return response.push(part) * d.inertia
