"""The ledger of live tracing: each step with its evidence, the findings, the effects in force."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from service.live.trace_content import TraceContent
from service.live.tracing_state import Role, TracingState

EVIDENCE_FIELDS = ("p_value", "share")
"""The fields of a finding that a step about it repeats."""


def findings(state: TracingState) -> tuple[dict[str, Any], ...]:
    """The findings that are proven, then those that are only suspected, each with what is known of it by now."""
    listed: dict[str, dict[str, Any]] = {}
    for role, content in _candidates(state):
        about: dict[str, Any] = {"state": role, "since": content.since, "until": content.until}
        if content.proof is not None:
            about |= {"until": content.proof.until, "error": content.proof.error}
        for finding in content.effects:
            listed.setdefault(str(finding["effect"]), {**finding, **about})
    return tuple(listed.values())


def evidence(content: TraceContent | None) -> dict[str, dict[str, Any]]:
    """Effect → p-value, share and, once it has been compared on fresh data, the errors before and after."""
    if content is None:
        return {}
    error = {} if content.proof is None else {"error": content.proof.error}
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
