"""The search: which set of effects explains the recordings, no more and no less."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect
from incsvr.evidence import evidence
from incsvr.tracer.hypothesis import Hypothesis, below_sampling, nothing, price, settle, views
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array
from incsvr.tracer.whitening import whiten

THRESHOLD = 16.0
"""Least gain of the criterion by which an effect is added."""

ON_ONE_SINE = 0.35
"""Of what all effects of the motion gain, where the command is one sine: rate, heading, thrust and their derivatives
are functions of one phase there, and two of them fit the shape error of any third."""

CONTRIBUTION = 0.1
"""Least deviation of what an effect alone explains, in deviations of the block residual."""

SHAPE = 0.06
"""Of the largest effect's contribution: the catalogue knows no effect's true shape more closely than that.

What is left of the wrong shape of an effect of the motion is a function of the motion. It can pass for another such
effect, and must be outdone by one; a bias, a drift or an extra channel is none.
"""

BEAM = ((6, 9), (4, 5), (2, 4), (1, 4), (1, 4))
"""For sets of one, two, … effects: how many are grown further, and how many leads of each smaller set are followed."""

PROVEN = 0.9
"""Free-run error, in parts of that without an effect, below which a residual that rose is no objection to it."""

SIMPLER = 0.1
"""Part of an effect's gain that is given away for one effect less."""

CLIMBERS = 2
"""How many of the best additions to what the gates let pass are put before them in turn."""

HOPELESS = -20.0
"""Score below which a lead is not settled."""

FINALISTS = 4
"""How many of the best sets are put before the gates."""


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
    q, r = np.linalg.qr(root * whiten(base.columns, ar, problem.blocks))
    z = root[:, 0] * whiten(base.fit.residual, ar, problem.blocks)
    variance = float(z @ z) / z.size
    pulled = variance if coloured else 0.0
    stretch = np.maximum(1.0 + base.turned @ base.fit.theta, 0.1)[:, None]
    turned = np.sum((base.turned / stretch)[problem.blocks.whole], axis=0)
    upright = r + 1e-9 * np.diag(np.abs(np.diag(r)) + 1e-300)
    seen = views(problem, base)
    leads = []
    for effect in effects:
        best: Lead | None = None
        s = seen.of(effect)
        for inner in effect.starts(s):
            columns = problem.blocks.mean(effect.columns(s, inner, ()))
            pull = np.sum((seen.turned(effect, inner, (), columns) / stretch)[problem.blocks.whole], axis=0)
            if not np.all(np.isfinite(columns)):
                continue
            c = root * whiten(columns, ar, problem.blocks)
            size = np.einsum("ij,ij->j", c, c)
            along = q.T @ c
            c = c - q @ along
            # what the Jacobian adds to the score, less what the base's own columns would take of it
            score = c.T @ z + pulled * (pull - np.linalg.solve(upright, along).T @ turned)
            told = np.diag(c.T @ c) > 1e-9 * size + 1e-300
            if not np.all(told[: effect.core]):
                continue
            c, score = c[:, told], score[told]  # an offset that another effect's column already is
            normal = c.T @ c
            # what merely places its zero does not count
            gain = _explained(normal, score) - _explained(normal[effect.core :, effect.core :], score[effect.core :])
            gain = -z.size * float(np.log(max(1.0 - gain / (z.size * variance), 1e-9)))
            worth = gain - price(effect, effect.core, problem)
            if best is None or worth > best.score:
                best = Lead(effect, inner, worth, gain)
        if best is not None:
            leads.append(best)
    return sorted(leads, key=lambda lead: -lead.score)


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


def _except(problem: Problem, base: Hypothesis, out: Sequence[int]) -> Hypothesis:
    """`base` with several effects taken out."""
    for k in sorted(out, reverse=True):
        base = without(problem, base, k)
    return base


def best_leads(problem: Problem, base: Hypothesis, effects: Sequence[Effect], width: int) -> list[Lead]:
    """The `width` best of the coloured scan and a third as many of the white one, once each."""
    first = _spread(scan(problem, base, effects), width)
    second = _spread(scan(problem, base, effects, coloured=False), (width + 2) // 3)
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


def against_physics(problem: Problem, hypothesis: Hypothesis) -> tuple[str, int] | None:
    """Why physics forbids one of the effects, and which."""
    seen = views(problem, hypothesis)
    for k, (effect, term) in enumerate(zip(hypothesis.effects, hypothesis.terms, strict=True)):
        if not np.all(np.isfinite(term.coefficients)):
            return "no finite fit", k
        reason = effect.implausible(term, seen.of(effect))
        if reason:
            return reason, k
    values = {term.effect: term.coefficients[0] for term in hypothesis.terms}
    if values.get("torque_delay", 0.0) < 0.0 < values.get("torque_lag", 0.0):
        return "a lag against a negative delay is no effect but a shape", hypothesis.names().index("torque_lag")
    return None


def sound(problem: Problem, hypothesis: Hypothesis) -> tuple[str, int]:
    """Why a hypothesis cannot stand (physics, size), and for which effect; an empty reason if it can."""
    forbidden = against_physics(problem, hypothesis)
    if forbidden:
        return forbidden
    alone = [unique_share(problem, hypothesis, k) for k in range(len(hypothesis.terms))]
    order = sorted(range(len(alone)), key=lambda k: alone[k])
    if order and alone[order[0]] < CONTRIBUTION:
        return "what it alone explains is lost in the noise", order[0]
    terms = zip(hypothesis.effects, hypothesis.terms, strict=True)
    phased = [e.of_phase and not below_sampling(t, problem) for e, t in terms]
    largest = max((alone[k] for k in order if phased[k]), default=0.0)
    for k in order:
        if phased[k] and alone[k] < SHAPE * largest:
            return "what it alone explains is within the shape error of a larger effect", k
    return "", 0


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
        return float(np.mean(np.abs(h.fit.residual - np.median(h.fit.residual))))

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
    """One search; it remembers what its gates refused.

    Attributes:
        problem: the equations.
        effects: what may be added.
        free_run: the judge of every effect: what improves the equation alone is not added.
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
        """The best set that passes every gate, out of a beam search by the equation alone.

        Two effects may each look wrong without the other: no gate but physics stands between the steps.
        """
        base = nothing(self.problem)
        beam, seen = [base], [base]
        for width, tries in BEAM[: self.most]:
            grown = self._grown(beam, tries)
            beam = grown[:width]
            if not beam or worth(beam[0]) <= max(map(worth, seen)):
                break
            seen += grown
        best = base
        for finalist in self._finalists(seen):
            cleaned = self._clean(finalist)
            if self._beats(cleaned, best) and self.free_run.better(cleaned, base):
                best = cleaned
        best = self._simpler(self._climbed(best))
        for name in best.names():
            self.refused.pop(name, None)
        return best

    def _climbed(self, base: Hypothesis) -> Hypothesis:
        """`base` with what the gates let in one by one: where they threw an effect out, another may take its place."""
        while len(base.terms) < self.most:
            steps = (self._clean(grown) for grown in self._grown([base], 5)[:CLIMBERS])
            best = next((step for step in steps if self._beats(step, base)), base)
            if best is base:
                break
            base = best
        return base

    def _simpler(self, base: Hypothesis) -> Hypothesis:
        """`base` without an effect that another form of one of the others explains as well.

        A thrust scaled by a channel about another level is the same about the channel's mean, and another inertia.
        """
        for k, less in permutations(range(len(base.terms)), 2):
            forms = [e for e in self.effects if e.name == base.effects[k].name and e.key != base.effects[k].key]
            if not forms:
                continue
            others = _except(self.problem, base, (k, less))
            allowed = SIMPLER * (base.criterion - without(self.problem, base, less).criterion)
            for lead in scan(self.problem, others, forms):
                one = with_lead(self.problem, others, lead)
                if one.criterion >= base.criterion - allowed and not sound(self.problem, one)[0]:
                    return self._simpler(one)
        return base

    def _finalists(self, seen: Sequence[Hypothesis]) -> list[Hypothesis]:
        """The best by the equation; where the torque answers the disturbances the best by the free run, too."""
        best = sorted(seen, key=worth, reverse=True)[:FINALISTS]
        if self.closed_loop:
            best += [h for h in sorted(seen, key=self.free_run)[:FINALISTS] if h not in best]
        return best

    def _beats(self, new: Hypothesis, old: Hypothesis) -> bool:
        """The free run has the first word; where it cannot tell the two apart, the equation."""
        if self.free_run.better(new, old) != self.free_run.better(old, new):
            return self.free_run.better(new, old)
        return worth(new) > worth(old)

    def _grown(self, beam: Sequence[Hypothesis], tries: int) -> list[Hypothesis]:
        """The hypotheses of the beam, each with one more effect; one for each set of names, best first."""
        grown: dict[frozenset[str], Hypothesis] = {}
        settled: set[frozenset[str]] = set()
        for base in beam:
            fitting = [e for e in self.effects if e.name not in base.names()]
            leads = best_leads(self.problem, base, fitting, tries)
            for lead in (lead for lead in leads if lead.score > HOPELESS):
                keys = frozenset(e.key for e in (*base.effects, lead.effect))
                if keys in settled and len(keys) > 1:  # the same set came from another of its members
                    continue
                settled.add(keys)
                new = with_lead(self.problem, base, lead)
                names = frozenset(new.names())
                known = grown.get(names)
                if worth(new) <= worth(base) or (known is not None and worth(known) >= worth(new)):
                    continue
                if not against_physics(self.problem, new):
                    grown[names] = new
        return sorted(grown.values(), key=worth, reverse=True)

    def _clean(self, base: Hypothesis) -> Hypothesis:
        """`base` without the effects that do not pass every gate beside the others, the least of them first."""
        while base.terms:
            reason, k = self._objection(base)
            if not reason:
                return base
            self.refused[base.names()[k]] = reason
            base = without(self.problem, base, k)
        return base

    def _objection(self, base: Hypothesis) -> tuple[str, int]:
        """What speaks against one effect of a hypothesis, and which; empty if nothing does."""
        reason, k = sound(self.problem, base)
        if reason:
            return reason, k
        gains = [evidence(self.problem, base, j) for j in range(len(base.terms))]
        paid = [price(e, e.core, self.problem) + THRESHOLD for e in base.effects]
        k = min(range(len(gains)), key=lambda j: gains[j] - paid[j])
        if gains[k] < paid[k]:
            return f"too little evidence for noise of this colour: 2 Δℓ is {gains[k]:.0f}, {paid[k]:.0f} is asked", k
        terms = zip(base.effects, base.terms, strict=True)
        phased = [j for j, (e, t) in enumerate(terms) if e.of_phase and not below_sampling(t, self.problem)]
        if self.problem.one_sine and len(phased) > 1:
            k = min(phased, key=lambda j: gains[j])
            if gains[k] < ON_ONE_SINE * (base.criterion - _except(self.problem, base, phased).criterion):
                return "a command of one sine cannot tell it from the shape error of another effect of the motion", k
        for k in range(len(base.terms)):
            less = without(self.problem, base, k)
            proven = self.free_run(base) < PROVEN * self.free_run(less)
            if _rose(base, less) and not proven:
                return "with it the residual grows: it explains the residual's colour, not its size", k
            if not self.free_run.better(base, less):
                return (
                    "it improves the torque equation, but the free run on unseen data gets no better: "
                    f"{self.free_run(less):.3g} rad/s without it, {self.free_run(base):.3g} rad/s with it"
                ), k
        return "", 0
