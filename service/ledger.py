"""What the ledger says of live tracing: each step with its evidence, and what was found and is not in force."""

from __future__ import annotations

from typing import Any

from service.standing import Content, Standing

EVIDENCE = ("p_value", "share")
"""Of a finding, what a step about it repeats."""


def findings(standing: Standing) -> tuple[dict[str, Any], ...]:
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
