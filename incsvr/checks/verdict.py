"""The findings of checks: a sentence for each, and the decision for learning."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum

from incsvr.plant.words import AxisWords


class Decision(IntEnum):
    """The decision of a finding; the graver is the larger."""

    CLEAN = 0
    WARN = 1
    """The finding is reported; learning continues."""
    PAUSE = 2
    """The batch is put aside: what is learned from it would be wrong."""


CHANGE = "change"
"""The kind of a finding that the vehicle changed: no fault."""
CHANGE_MEMORY_S = 300.0
"""Time for which a change of the vehicle is said [s]."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that a check saw.

    Attributes:
        kind: one word for the cause, the same as long as the cause lasts.
        decision: what follows.
        sentence: for people, with figures and times; it names the cure where there is one. A check writes a template
            of `AxisWords`, which the judgement fills.
    """

    kind: str
    decision: Decision
    sentence: str

    def in_words(self, words: AxisWords) -> Finding:
        """The finding with its sentence filled with these words."""
        return replace(self, sentence=words.fill(self.sentence))


@dataclass(frozen=True, slots=True)
class Verdict:
    """The findings of all checks on one batch.

    Attributes:
        findings: the gravest first.
        learn: whether the batch is to be learned from.
        suspect: learning has just paused, and the batch before may have been touched by the same fault.
        span: time of the batch's first and last sample [s].
    """

    findings: tuple[Finding, ...]
    learn: bool
    suspect: bool
    span: tuple[float, float]

    def in_words(self, words: AxisWords) -> Verdict:
        """The verdict with the sentences of its findings, which are templates until then, filled with these words."""
        return replace(self, findings=tuple(each.in_words(words) for each in self.findings))

    @property
    def decision(self) -> Decision:
        return self.findings[0].decision if self.findings else Decision.CLEAN


@dataclass(frozen=True, slots=True)
class CurrentWarnings:
    """The present warnings on the sensors, after the verdicts so far.

    Attributes:
        paused: why learning is paused, in one sentence; None where it goes on.
        warnings: what was seen of the last batch, and else.
        change: the time [s] and the sentence of the last change of the vehicle.
    """

    paused: str | None = None
    warnings: tuple[str, ...] = ()
    change: tuple[float, str] | None = None

    def after(self, verdict: Verdict) -> CurrentWarnings:
        """The warnings after the verdict on the next batch."""
        now = verdict.span[1]
        change = self.change if self.change is not None and 0.0 <= now - self.change[0] < CHANGE_MEMORY_S else None
        sentences = [finding.sentence for finding in verdict.findings if finding.decision < Decision.PAUSE]
        changes = [finding.sentence for finding in verdict.findings if finding.kind == CHANGE]
        if changes:
            change = now, changes[0]
        elif change is not None:
            sentences.append(change[1])
        pausing = [finding.sentence for finding in verdict.findings if finding.decision >= Decision.PAUSE]
        paused = None if verdict.learn else "; ".join(pausing) or self.paused or "the newest samples are not judged yet"
        return CurrentWarnings(paused, tuple(sentences), change)


def verdict_sentences(verdicts: Iterable[Verdict]) -> list[str]:
    """The sentences on a series of verdicts: one for each finding as long as it lasts."""
    sentences: list[str] = []
    lasting: dict[str, int] = {}  # kind → where its sentence stands
    aside, since, until = 0, 0.0, 0.0
    for verdict in verdicts:
        kinds = {finding.kind: finding.sentence for finding in verdict.findings}
        lasting = {kind: place for kind, place in lasting.items() if kind in kinds}
        for kind, sentence in kinds.items():
            if kind not in lasting:
                lasting[kind] = len(sentences)
                sentences.append(sentence)
        if not verdict.learn:
            since = since if aside else verdict.span[0]
            aside, until = aside + 1, verdict.span[1]
        elif aside:
            sentences.append(_put_aside(aside, since, until))
            aside = 0
    return [*sentences, _put_aside(aside, since, until)] if aside else sentences


def _put_aside(count: int, since: float, until: float) -> str:
    return f"{count} {'batch was' if count == 1 else 'batches were'} put aside, from {since:.10g} to {until:.10g} s"
