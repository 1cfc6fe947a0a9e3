"""What the ledger says of live tracing: each step with its evidence, what was found, what is in force, in its words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from service.live.tracing_state import Content, Role, TracingState

EVIDENCE = ("p_value", "share")
"""Of a finding, what a step about it repeats."""


def findings(standing: TracingState) -> tuple[dict[str, Any], ...]:
    """The findings that are proven, then those that are only suspected, each with what is known of it by now."""
    listed: dict[str, dict[str, Any]] = {}
    for state, content in (("proven", standing.proven), ("suspected", standing.shadow)):
        if content is None:
            continue
        proof = content.get("proof") or {}
        about = {"state": state, "since": content.get("since"), "until": proof.get("until", content.get("until"))}
        if "error" in proof:
            about["error"] = proof["error"]
        for finding in content["effects"]:
            listed.setdefault(str(finding["effect"]), {**finding, **about})
    return tuple(listed.values())


def evidence(content: Content | None) -> dict[str, dict[str, Any]]:
    """Effect → p-value, share and, once it has been compared on fresh data, the errors before and after."""
    if content is None:
        return {}
    error = (content.get("proof") or {}).get("error")
    return {
        str(finding["effect"]): {name: finding[name] for name in EVIDENCE if finding.get(name) is not None}
        | ({} if error is None else {"error": error})
        for finding in content["effects"]
    }


def offered(standing: TracingState, names: Callable[[Content], Sequence[str]]) -> dict[str, tuple[Role, Content]]:
    """Effect → the trace that holds it and could be promoted, a proven one rather than a suspected one."""
    found: dict[str, tuple[Role, Content]] = {}
    ordered: tuple[tuple[Role, Content | None], ...] = (("proven", standing.proven), ("suspected", standing.shadow))
    for role, content in ordered:
        if content is not None:
            for name in names(content):
                found.setdefault(name, (role, content))
    return found


def last(standing: TracingState, names: Sequence[str]) -> str | None:
    """The last step about these effects."""
    return next((step["step"] for step in reversed(standing.history) if step["effect"] in names), None)


def together(name: str, names: Sequence[str]) -> str:
    """What else was promoted or withdrawn with this effect."""
    others = [each for each in names if each != name]
    return f", together with {', '.join(others)}, which one trace found beside it" if others else ""


def in_force(names: Sequence[str]) -> str:
    """The effects in force."""
    return f"in force: {', '.join(names) or 'nothing'}"
