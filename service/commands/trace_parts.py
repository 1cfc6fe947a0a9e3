"""The trace of a recording's part after a step: one model of both parts would name effects that neither has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.tracing.findings import Trace
from incsvr.tracing.sentences import headline
from service.logs.cutting import Span
from service.recordings.cut_recordings import between
from service.recordings.recording import Recording

ONSET_PARAMETER = "at_s"
"""The parameter of an effect that begins at one instant [s of the recordings]."""


MIN_PART_SHARE = 0.1
"""Part of the recorded time that the part after a step lasts at least, to be traced by itself."""


@dataclass(frozen=True, slots=True)
class Part:
    """The recordings from one step to the next, or to their end.

    Attributes:
        after: the effects that step there.
        begin, end: from and to [s of the recordings]; infinite where it goes on to their end.
        trace: what it shows by itself; None where it cannot be traced.
        refused: why it cannot be traced; else empty.
        origin: from which `--from` counts [s of the recordings]: their beginning where stamps count since 1970.
    """

    after: tuple[str, ...]
    begin: float
    end: float
    trace: Trace | None
    refused: str = ""
    origin: float = 0.0

    @property
    def sentence(self) -> str:
        """The sentence for people."""
        begin, end = f"{self.begin - self.origin:.6g}", f"{self.end - self.origin:.6g}"
        span = f"from {begin} s on" if self.end == inf else f"from {begin} to {end} s"
        where = f"{span}, after {' and '.join(self.after)}, the rest of the recording"
        if self.trace is None:
            return f"{where} cannot be traced: {self.refused}"
        cut = f"--from {begin}" if self.end == inf else f"--from {begin} --to {end}"
        return f"{where} shows: {headline(self.trace)} ({cut} traces it alone)"

    def to_dict(self) -> dict[str, Any]:
        shown = {} if self.trace is None else {
            "headline": headline(self.trace),
            "verdict": self.trace.verdict,
            "effects": [finding.to_dict() for finding in self.trace.effects],
        }  # fmt: skip
        return {
            "after": list(self.after),
            "from": self.begin,
            "to": self.end if isfinite(self.end) else None,
            **shown,
            **({"refused": self.refused} if self.refused else {}),
        }


def after_steps(
    trace: Trace, recordings: Sequence[Recording], by_itself: Callable[[Sequence[Recording]], Trace]
) -> tuple[Part, ...]:
    """The parts after each step that a trace found, each traced by itself.

    Args:
        trace: the trace of the recordings.
        by_itself: traces recordings as the whole was traced.
    """
    steps = _steps(trace)
    if not steps:
        return ()
    last = max(float(each.time[-1]) for each in recordings)
    origin = Span(min(float(each.time[0]) for each in recordings), last).origin
    shortest = MIN_PART_SHARE * sum(float(np.ptp(each.time)) for each in recordings)
    parts, before = list[Part](), tuple[str, ...]()
    for k, step in enumerate(steps):
        end = steps[k + 1].since if k + 1 < len(steps) else inf
        if min(end, last) - step.over < shortest:
            before += step.effects  # what follows soon goes with it
        else:
            part = Part((*before, *step.effects), step.over, end, None, origin=origin)
            parts.append(_traced(part, recordings, by_itself))
            before = ()
    return tuple(parts)


@dataclass(frozen=True, slots=True)
class _Step:
    """Effects that begin at one instant: not before `since`, and for certain by `over` [s]."""

    since: float
    over: float
    effects: tuple[str, ...]


def _steps(trace: Trace) -> list[_Step]:
    """The steps that were found, in order; those whose intervals meet are one."""
    spans = sorted(
        (*_certain(finding.interval.get(ONSET_PARAMETER), finding.parameters[ONSET_PARAMETER]), finding.effect)
        for finding in trace.effects
        if ONSET_PARAMETER in finding.parameters
    )
    steps: list[_Step] = []
    for since, over, effect in spans:
        if steps and since <= steps[-1].over:
            one = steps.pop()
            steps.append(_Step(one.since, max(one.over, over), (*one.effects, effect)))
        else:
            steps.append(_Step(since, over, (effect,)))
    return steps


def _certain(interval: Sequence[float] | None, at: float) -> tuple[float, float]:
    """The ends of an interval [s]; the estimate alone where there is none."""
    low, high = (at, at) if interval is None else interval
    return (low, high) if isfinite(low) and isfinite(high) else (at, at)


def _traced(part: Part, recordings: Sequence[Recording], by_itself: Callable[[Sequence[Recording]], Trace]) -> Part:
    """The part with what it shows by itself, or why it cannot be traced."""
    cut = [rows for each in recordings if (rows := between(each, part.begin, part.end)).time.size]
    if not cut:
        return replace(part, refused="nothing was recorded in it")
    try:
        return replace(part, trace=by_itself(cut))
    except BadInput as error:
        return replace(part, refused=str(error))
