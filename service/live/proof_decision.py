"""The decision on traced effects after a comparison on fresh data, under `advise` or `adopt`, for the ledger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from incsvr.compensation.proof import Proof, Verdict
from incsvr.plant.words import YAW_WORDS, AxisWords
from service.config.sections import Tracing
from service.live.ledger import last_step
from service.live.trace_content import TraceContent
from service.live.tracing_state import Role, TracingState


@dataclass(frozen=True, slots=True)
class ProofDecision:
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
    error = proof.error if proof.turned else None if content.proof is None else content.proof.error
    why = proof.sentence(words) if proof.turned else "the vehicle hardly turned since the trace"
    if verdict in ("kept", "waits") or (step == "doubtful" and last_step(state, names) == step):
        return ProofDecision(verdict, None, why, error)
    instead = "in place of those in force, " if suspected and state.active is not None else ""
    cure = f"; to take it back: incsvr effects withdraw {names[0]}" if step == "doubtful" else ""
    return ProofDecision(verdict, step, instead + why + cure, error)
