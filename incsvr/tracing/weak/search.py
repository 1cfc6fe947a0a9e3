"""The search: which set of effects explains the recordings, no more and no less."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

from incsvr.effects import Effect
from incsvr.tracing.weak.acceptance import against_physics, objection, pays
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, nothing
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import LEAST_GAIN, STRONG, FreeRun, penalised_criterion
from incsvr.tracing.weak.scan import best_leads, with_lead, without

BEAM = ((6, 9), (4, 5), (2, 4), (1, 4), (1, 4))
"""For sets of one, two, … effects: how many are grown further, and how many leads of each smaller set are followed."""

FOLLOWED = 12
"""How many leads are settled where several sets are grown at once: those that promise most."""

BETTER = 1.0
"""Of the criterion: a set of effects that was judged is judged again where it comes with values so much better."""

CLIMBS = 12
"""How many leads are tried as an addition to what the gates let pass."""

CLIMBERS = 2
"""How many of the best of these are put before the gates in turn."""

HOPELESS = (-20.0, 0.0)
"""Score below which a lead is not settled: beside nothing, where what is there may still hide it, and beside others."""

FINALISTS = 4
"""How many of the best sets are put before the gates."""


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
        judged: keys of a set of effects → as it was judged, and what the gates left of it: itself, or one effect less.
        tried: keys of a set of effects → the best that came of it when sets were grown.
    """

    problem: Problem
    effects: Sequence[Effect]
    free_run: FreeRun
    closed_loop: bool = False
    most: int = 5
    refused: dict[str, str] = field(default_factory=dict)
    judged: dict[frozenset[str], tuple[Hypothesis, Hypothesis]] = field(default_factory=dict)
    tried: dict[frozenset[str], Hypothesis] = field(default_factory=dict)

    def run(self) -> Hypothesis:
        """The best set that passes every gate, out of a beam search by the equation alone.

        Two effects may each look wrong without the other: no gate but physics stands between the steps.
        """
        base = nothing(self.problem)
        beam, seen = [base], [base]
        for width, tries in BEAM[: self.most]:
            grown = self._grown(beam, tries)
            beam = grown[:width]
            for one in grown:
                keys = frozenset(effect.key for effect in one.effects)
                self.tried[keys] = max(one, self.tried.get(keys, one), key=penalised_criterion)
            if not beam or (
                len(beam[0].terms) > 1 and max(map(penalised_criterion, beam)) <= max(map(penalised_criterion, seen))
            ):
                break
            seen += grown
        best = base
        for finalist in self._finalists(seen):
            cleaned = self._clean(finalist)
            # the proof will ask for a free run that is better as it is, whatever the weighed one says
            proves = self.free_run(cleaned) < self.free_run(base)
            if proves and self._beats(cleaned, best) and pays(self.problem, self.free_run, cleaned, base):
                best = cleaned
        best = self.climbed(best)
        for name in best.names():
            self.refused.pop(name, None)
        return best

    def climbed(self, base: Hypothesis) -> Hypothesis:
        """`base` with what the gates let in one by one: where they threw an effect out, another may take its place."""
        while len(base.terms) < self.most:
            steps = (self._clean(grown) for grown in self._grown([base], CLIMBS)[:CLIMBERS])
            best = next((step for step in steps if self._beats(step, base)), base)
            if best is base:
                break
            base = best
        return base

    def _finalists(self, seen: Sequence[Hypothesis]) -> list[Hypothesis]:
        """The best by the equation, and the best single effect, lest it go down with those it was grown into."""
        ranked = sorted(seen, key=penalised_criterion, reverse=True)
        best = ranked[:FINALISTS]
        return best if any(len(h.terms) == 1 for h in best) else best + [h for h in ranked if len(h.terms) == 1][:1]

    def _beats(self, new: Hypothesis, old: Hypothesis) -> bool:
        """The free run has the first word; where it cannot tell the two apart, the equation.

        But where no feedback biases the equation, and it leaves no doubt, one standard error of the free run is none;
        nor is it one for what may be the noise's colour or the sampling where the equation prefers another.
        """
        if self._doubtful(new) != self._doubtful(old):
            doubtful, other = (new, old) if self._doubtful(new) else (old, new)
            if penalised_criterion(other) >= penalised_criterion(doubtful):
                return other is new
        if not self.closed_loop and abs(penalised_criterion(new) - penalised_criterion(old)) > STRONG:
            return penalised_criterion(new) > penalised_criterion(old)
        if self.free_run.better(new, old) != self.free_run.better(old, new):
            return self.free_run.better(new, old)
        return penalised_criterion(new) > penalised_criterion(old)

    def _doubtful(self, hypothesis: Hypothesis) -> bool:
        """Whether it holds an effect that the noise's colour might be taken for, or nothing but how it was sampled."""
        named = zip(hypothesis.effects, hypothesis.terms, strict=True)
        sampled = bool(hypothesis.terms) and all(below_sampling(term, self.problem) for term in hypothesis.terms)
        return sampled or any(effect.must_prove(term, self.problem.signals) for effect, term in named)

    def _grown(self, beam: Sequence[Hypothesis], tries: int) -> list[Hypothesis]:
        """The hypotheses of the beam, each with one more effect; one for each set of names, best first.

        Of two that hide each other neither is worth its price alone; what would explain most of white noise, an AR may
        have swallowed: it is grown further before the others. On one sine any two seem so.
        """
        grown: dict[frozenset[str], Hypothesis] = {}
        settled: set[frozenset[str]] = set()
        swallowed: set[frozenset[str]] = set()
        fitting = [[effect for effect in self.effects if effect.name not in base.names()] for base in beam]
        found = [best_leads(self.problem, base, f, tries) for base, f in zip(beam, fitting, strict=True)]
        promise = sorted(
            penalised_criterion(b) + lead.score for b, leads in zip(beam, found, strict=True) for lead in leads
        )
        floor = promise[-FOLLOWED] if len(beam) > 1 and len(promise) > FOLLOWED else -inf
        for base, leads in zip(beam, found, strict=True):
            first, least = not base.terms and not self.problem.one_sine, HOPELESS[bool(base.terms)]
            leads = [lead for lead in leads if lead.score > least and penalised_criterion(base) + lead.score >= floor]
            sets = [frozenset(e.key for e in (*base.effects, lead.effect)) for lead in leads]
            for keys, lead in zip(sets, leads, strict=True):
                if keys in settled:  # the same set came from another of its members
                    continue
                new = with_lead(self.problem, base, lead)
                names = frozenset(new.names())
                known = grown.get(names)
                insufficient = penalised_criterion(new) <= penalised_criterion(base) - (LEAST_GAIN if first else 0.0)
                worse = (insufficient and not (first and lead.hidden)) or (
                    known is not None and penalised_criterion(known) >= penalised_criterion(new)
                )
                if not worse and not against_physics(self.problem, new):
                    grown[names] = new
                    swallowed |= {names} if insufficient else set()
            settled |= set(sets)
        return sorted(
            grown.values(), key=lambda h: (frozenset(h.names()) in swallowed, penalised_criterion(h)), reverse=True
        )

    def _reduced(self, base: Hypothesis, k: int) -> Hypothesis:
        """`base` without its k-th effect, which the others may have grown around: as it was before, where that is
        better."""
        reduced = without(self.problem, base, k)
        before = self.tried.get(frozenset(effect.key for effect in reduced.effects), reduced)
        return max(reduced, before, key=penalised_criterion)

    def _clean(self, base: Hypothesis) -> Hypothesis:
        """`base` without the effects that do not pass every gate beside the others, the least of them first."""
        while base.terms:
            keys = frozenset(effect.key for effect in base.effects)
            better = keys in self.judged and base.criterion > self.judged[keys][0].criterion + BETTER
            if keys not in self.judged or better:
                reason, k = objection(self.problem, self.free_run, base)
                if reason:
                    self.refused[base.names()[k]] = reason
                self.judged[keys] = base, self._reduced(base, k) if reason else base
            base, left = self.judged[keys]
            if left.names() == base.names():
                return left
            base = left
        return base
