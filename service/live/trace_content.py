"""A trace as live tracing keeps it: its effects, the model that holds them, the data it is of, and its last proof."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True, slots=True)
class FreshProof:
    """The last comparison of a trace's effects on fresh data that could tell.

    Attributes:
        error: the errors before and after, in the form of CONTRACT, Section 5.
        until: the newest of the data [s].
    """

    error: Mapping[str, Any]
    until: float


@dataclass(frozen=True, slots=True)
class TraceContent:
    """A trace, as far as it is needed.

    Attributes:
        effects: its findings, in the form that `incsvr trace --json` writes.
        model: the traced model, likewise.
        loop: whether the torque answers the rate, `open` or `closed`; None where an earlier version kept none.
        since: the time from which on its data begin [s].
        until: the newest of its data [s].
        proof: None before its effects were compared on fresh data.
    """

    effects: tuple[Mapping[str, Any], ...]
    model: Mapping[str, Any]
    loop: str | None = None
    since: float | None = None
    until: float | None = None
    proof: FreshProof | None = None

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TraceContent:
        """The content whose `to_dict` gave `data`, or that of a whole trace."""
        proof = data.get("proof")
        return TraceContent(
            tuple(data["effects"]),
            data["model"],
            data.get("loop"),
            data.get("since"),
            data.get("until"),
            None if proof is None else FreshProof(proof["error"], proof["until"]),
        )

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data."""
        proof = {} if self.proof is None else {"proof": {"error": self.proof.error, "until": self.proof.until}}
        return {
            "effects": list(self.effects),
            "model": self.model,
            "loop": self.loop,
            "since": self.since,
            "until": self.until,
            **proof,
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Its effects by name, in the order in which they were added."""
        return tuple(str(finding["effect"]) for finding in self.effects)

    def compared(self, error: Mapping[str, Any], until: float) -> TraceContent:
        """The content after a comparison on fresh data up to `until` [s]."""
        return replace(self, proof=FreshProof(error, until))
