"""The ledger of live tracing: each step with its evidence, the findings, the effects in force."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from incsvr.compensation.proof import Proof, Verdict
from incsvr.plant.words import YAW_WORDS, AxisWords
from service.config.sections import Tracing
from service.live.tracing_state import Role, TraceContent, TracingState

EVIDENCE_FIELDS = ("p_value", "share")
"""The fields of a finding that a step about it repeats."""


def findings(state: TracingState) -> tuple[dict[str, Any], ...]:
    """The findings that are proven, then those that are only suspected, each with what is known of it by now."""
    listed: dict[str, dict[str, Any]] = {}
    for role, content in _candidates(state):
        about: dict[str, Any] = {"state": role, "since": content.since, "until": content.until}
        if content.proof is not None:
            about |= content.proof
        for finding in content.effects:
            listed.setdefault(str(finding["effect"]), {**finding, **about})
    return tuple(listed.values())


def evidence(content: TraceContent | None) -> dict[str, dict[str, Any]]:
    """Effect → p-value, share and, once it has been compared on fresh data, the errors before and after."""
    if content is None:
        return {}
    error = {} if content.proof is None else {"error": content.proof["error"]}
    return {
        str(finding["effect"]): {name: finding[name] for name in EVIDENCE_FIELDS if finding.get(name) is not None}
        | error
        for finding in content.effects
    }


def promotable(
    state: TracingState, names: Callable[[TraceContent], Sequence[str]]
) -> dict[str, tuple[Role, TraceContent]]:
    """Effect → the trace that holds it and could be promoted, a proven one rather than a suspected one."""
    found: dict[str, tuple[Role, TraceContent]] = {}
    for role, content in _candidates(state):
        for name in names(content):
            found.setdefault(name, (role, content))
    return found


def _candidates(state: TracingState) -> Iterator[tuple[Role, TraceContent]]:
    """The proven and the suspected trace, if there is one."""
    if state.proven is not None:
        yield "proven", state.proven
    if state.suspect is not None:
        yield "suspected", state.suspect


def last_step(state: TracingState, names: Sequence[str]) -> str | None:
    """The last step about these effects."""
    return next((step["step"] for step in reversed(state.history) if step["effect"] in names), None)


def together(name: str, names: Sequence[str]) -> str:
    """The other effects that were promoted or withdrawn with this one."""
    others = [each for each in names if each != name]
    return f", together with {', '.join(others)}, which one trace found beside it" if others else ""


def in_force(names: Sequence[str]) -> str:
    """The effects in force."""
    return f"in force: {', '.join(names) or 'nothing'}"


class ProofDecision(NamedTuple):
    """The decision on the compared effects.

    Attributes:
        verdict: how live tracing goes on.
        step: of the ledger; None where it says nothing new.
        why: the step's sentence.
        error: before and after, of the last comparison that could tell; None where there was none.
    """

    verdict: Verdict
    step: str | None
    why: str
    error: Mapping[str, Any] | None


def decide_proof(
    state: TracingState,
    under_test: tuple[Role, TraceContent],
    names: Sequence[str],
    proof: Proof,
    newest: float,
    settings: Tracing,
    words: AxisWords = YAW_WORDS,
) -> ProofDecision:
    """The decision on the effects of these names.

    Args:
        state: of live tracing before.
        under_test: the trace that they are of, as `state.under_test` gives it.
        proof: with and without them on fresh data up to `newest` [s].
        words: what the reason calls the quantities of the axis.
    """
    (role, content), advise = under_test, settings.live == "advise"
    suspected, last = role == "suspected", state.overdue(newest + settings.proof, settings.window)
    verdict = proof.of_suspected(last) if suspected else proof.of_known()
    step: str = verdict
    if verdict == "promoted" and (advise or set(names) & set(state.vetoed)):
        step = verdict = "proven"
    elif verdict == "withdrawn" and role == "proven":
        step = "no longer proven"
    elif verdict == "withdrawn" and advise:
        step, verdict = "doubtful", "doubted"
    error = proof.error if proof.turned else None if content.proof is None else content.proof["error"]
    why = proof.sentence(words) if proof.turned else "the vehicle hardly turned since the trace"
    if verdict in ("kept", "waits") or (step == "doubtful" and last_step(state, names) == step):
        return ProofDecision(verdict, None, why, error)
    instead = "in place of those in force, " if suspected and state.active is not None else ""
    cure = f"; to take it back: incsvr effects withdraw {names[0]}" if step == "doubtful" else ""
    return ProofDecision(verdict, step, instead + why + cure, error)
