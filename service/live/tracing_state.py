"""The state of live tracing as a value: effects suspected, proven and in force, and the next work.

    trace → suspected → proof on fresh data → promoted → tried again and again → withdrawn

That is `adopt`. Under `advise` a proof ends with `proven`, and an operator alone promotes and withdraws; so it is under
`adopt` with what an operator has withdrawn.

All times are the vehicle's. What is to be done, and how far its data reach, follows from the data alone. Behind which
batch an answer falls, and with it an effect comes into force, depends on the clock on the wall: on how quickly data
came and how long the process took.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from incsvr.compensation.proof import Verdict


@dataclass(frozen=True, slots=True)
class TraceContent:
    """A trace, as far as it is needed.

    Attributes:
        effects: its findings, in the form that `incsvr trace --json` writes.
        model: the traced model, likewise.
        loop: whether the torque answers the rate, `open` or `closed`; None where an earlier version kept none.
        since: the time from which on its data begin [s].
        until: the newest of its data [s].
        proof: the last comparison of its effects on fresh data that could tell: `error`, before and after as `incsvr
            trace --json` has them, and `until`, the newest of the data [s]; None before there was one.
    """

    effects: tuple[Mapping[str, Any], ...]
    model: Mapping[str, Any]
    loop: str | None = None
    since: float | None = None
    until: float | None = None
    proof: Mapping[str, Any] | None = None

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TraceContent:
        """The content whose `to_dict` gave `data`, or that of a whole trace."""
        return TraceContent(
            tuple(data["effects"]),
            data["model"],
            data.get("loop"),
            data.get("since"),
            data.get("until"),
            data.get("proof"),
        )

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data."""
        return {
            "effects": list(self.effects),
            "model": self.model,
            "loop": self.loop,
            "since": self.since,
            "until": self.until,
            **({} if self.proof is None else {"proof": self.proof}),
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Its effects by name, in the order in which they were added."""
        return tuple(str(finding["effect"]) for finding in self.effects)

    def compared(self, error: Mapping[str, Any], until: float) -> TraceContent:
        """The content after a comparison on fresh data up to `until` [s]."""
        return replace(self, proof={"error": error, "until": until})


FRESH_PART = 0.25
"""This part of the window comes between two traces: a process beside the learner is not always busy, and what came on
lately is in all of the window's newest half before three quarters of a window passed."""
TRIAL_PART = 0.5
"""A suspected effect is compared on all data since its trace, each time that `tracing.proof` more has come, until that
is this part of the window; then it is proven or refused. What is in force is compared whenever so much is fresh. The
models are fitted to the rest of the window."""
MAX_STEPS = 60
"""Steps that the history keeps; the oldest go."""
RESIDUAL = "residual"
"""The subject of a step that concerns no effect."""

Work = Literal["trace", "prove"]
Role = Literal["suspected", "proven", "active"]


@dataclass(frozen=True, slots=True)
class TracingState:
    """The state of live tracing; all but the suspicion is durable, because the data that it is judged on are not.

    Attributes:
        active: the trace whose effects are in force.
        suspect: the trace whose effects are suspected.
        proven: the trace whose effects have proven themselves and wait for an operator.
        unseen_from: neither a trace nor a proof has seen what is younger than this [s].
        traced_until: the newest data of the last trace [s].
        vetoed: effects that an operator has withdrawn: nobody else promotes them again.
        history: every step, in the ledger's form.
    """

    active: TraceContent | None = None
    suspect: TraceContent | None = None
    proven: TraceContent | None = None
    unseen_from: float = 0.0
    traced_until: float | None = None
    vetoed: tuple[str, ...] = ()
    history: tuple[dict[str, Any], ...] = ()

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TracingState:
        """The state whose `to_dict` gave `data`; what an earlier version kept beside it is left out."""
        return TracingState(
            active=_content(data.get("force")),
            proven=_content(data.get("proven")),
            unseen_from=data.get("fresh", 0.0),
            traced_until=data.get("traced"),
            vetoed=tuple(data.get("held", ())),
            history=tuple(data.get("history", ())),
        )

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data, in the form of the durable state."""
        contents = {"force": self.active, "proven": self.proven}
        return {
            **{key: None if content is None else content.to_dict() for key, content in contents.items()},
            "fresh": self.unseen_from,
            "traced": self.traced_until,
            "held": list(self.vetoed),
            "history": list(self.history),
        }

    @property
    def under_test(self) -> tuple[Role, TraceContent] | None:
        """The trace that the next proof is about: what is suspected, else what was compared longest ago."""
        if self.suspect is not None:
            return "suspected", self.suspect
        others: list[tuple[Role, TraceContent]] = []
        if self.proven is not None:
            others.append(("proven", self.proven))
        if self.active is not None:
            others.append(("active", self.active))
        return min(others, key=lambda one: 0.0 if one[1].proof is None else one[1].proof["until"], default=None)

    def due(self, newest: float, window: float, proof: float, changed: float = -math.inf) -> Work | None:
        """The work that is due when a full window reaches up to `newest` [s].

        Effects are proven whenever enough is fresh. A trace begins where nothing is suspected, and sees something that
        the trace before has not seen.

        Args:
            newest: [s].
            window, proof: as configured [s].
            changed: the time of a change that pauses learning [s]: a trace waits for half a window of data after it.
        """
        wanted = proof if self.suspect else TRIAL_PART * window
        if self.under_test is not None and newest >= self.unseen_from + wanted:
            return "prove"
        # What was found is only found again.
        rest = FRESH_PART * window if self.proven is None and self.active is None else window
        rested = self.traced_until is None or newest >= self.traced_until + rest
        enough = newest >= changed + TRIAL_PART * window
        return "trace" if self.suspect is None and rested and enough else None

    def after_clock_restart(self, newest: float) -> TracingState:
        """The state after a restart of the vehicle's clock: all times count from now."""
        if newest >= max(self.unseen_from, self.traced_until or 0.0):
            return self
        return replace(self, suspect=None, unseen_from=newest, traced_until=None)

    def with_step(self, step: Mapping[str, Any], about: Sequence[str] = (RESIDUAL,)) -> TracingState:
        """The state with a further step of the history for each of these effects."""
        steps = tuple({"effect": name, **step} for name in about)
        return replace(self, history=(*self.history, *steps)[-MAX_STEPS:])

    def after_trace(self, newest: float, found: TraceContent | None) -> TracingState:
        """A trace of the data up to `newest` [s] ended; None where it found nothing that can be taken up."""
        unseen_from = self.unseen_from if found is None else newest
        return replace(self, suspect=found, traced_until=newest, unseen_from=unseen_from)

    def overdue(self, newest: float, window: float) -> bool:
        """Whether more than half a window passed since the trace of what is suspected: the data before it are going."""
        traced = self.traced_until
        return self.suspect is not None and traced is not None and newest > traced + TRIAL_PART * window

    def after_proof(self, newest: float, verdict: Verdict, error: Mapping[str, Any] | None = None) -> TracingState:
        """A proof of what is under test, on data up to `newest` [s], ended.

        Args:
            error: the errors before and after; None where no comparison could tell yet.
        """
        if self.under_test is None:
            return self
        role, content = self.under_test
        seen = content if error is None else content.compared(error, newest)
        on = replace(self, unseen_from=newest)
        match role, verdict:
            case "suspected", "promoted":
                return replace(on, active=seen, suspect=None)
            case "suspected", "proven":
                return replace(on, proven=seen, suspect=None)
            case "suspected", "refused":
                return replace(on, suspect=None)
            case "suspected", _:
                return replace(on, suspect=seen)
            case "proven", "withdrawn":
                return replace(on, proven=None)
            case "proven", _:
                return replace(on, proven=seen)
            case _, "withdrawn":
                return replace(on, active=None)
            case _, _:
                return replace(on, active=seen)

    def promote(self, role: Role) -> TracingState:
        """An operator has promoted what is suspected or proven."""
        chosen = self.suspect if role == "suspected" else self.proven
        if chosen is None:
            return self
        left = replace(self, suspect=None) if role == "suspected" else replace(self, proven=None)
        return replace(left, active=chosen, vetoed=tuple(name for name in self.vetoed if name not in chosen.names))

    def withdraw(self, names: Sequence[str]) -> TracingState:
        """An operator has withdrawn what is in force, these effects."""
        return replace(self, active=None, vetoed=tuple(dict.fromkeys((*self.vetoed, *names))))


def _content(data: Mapping[str, Any] | None) -> TraceContent | None:
    return None if data is None else TraceContent.from_dict(data)
