"""The decision on traced effects after a comparison on fresh data, under `advise` or `adopt`, for the ledger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from incsvr.compensation.promotion import FALSE_PROOF_CHANCE, Comparison, Verdict, in_force, level, on_trial
from incsvr.plant.words import YAW_WORDS, AxisWords
from service.config.sections import Tracing
from service.live.ledger import last_step
from service.live.trace_content import TraceContent
from service.live.tracing_state import TRIAL_PART, Role, TracingState


@dataclass(frozen=True, slots=True)
class ProofDecision:
    """The decision on the compared effects.

    Attributes:
        verdict: how live tracing goes on.
        step: of the ledger; None where it says nothing new.
        why: the step's sentence.
        error: before and after, of the last comparison that could tell; None where there was none.
        won: ln of what was won by bets on these data.
    """

    verdict: Verdict
    step: str | None
    why: str
    error: Mapping[str, Any] | None
    won: float


def decide_proof(
    state: TracingState,
    under_test: tuple[Role, TraceContent],
    names: Sequence[str],
    comparison: Comparison,
    newest: float,
    settings: Tracing,
    words: AxisWords = YAW_WORDS,
) -> ProofDecision:
    """The decision on the effects of these names.

    Args:
        state: of live tracing before.
        under_test: the trace that they are of, as `state.under_test` gives it.
        comparison: with and without them on fresh data up to `newest` [s].
        words: what the reason calls the quantities of the axis.
    """
    (role, content), advise = under_test, settings.live == "advise"
    step: str
    won, spent = 0.0, FALSE_PROOF_CHANCE
    if role == "suspected":
        at_last = newest + settings.proof > state.trial_from + TRIAL_PART * settings.window
        count, earlier = state.prior_bet
        won, comparison = comparison.won, comparison.after(earlier)
        spent = level(count)
        step = verdict = on_trial(comparison, spent, at_last)
    else:
        step = verdict = in_force(comparison)
    if verdict == "promoted" and (advise or set(names) & set(state.vetoed)):
        step = verdict = "proven"
    elif verdict == "withdrawn" and role == "proven":
        step = "no longer proven"
    elif verdict == "withdrawn" and advise:
        step, verdict = "doubtful", "doubted"
    error = comparison.error if comparison.turned else None if content.proof is None else content.proof.error
    again = step == "doubtful" and last_step(state, names) == step
    if verdict in ("kept", "waits") or again:
        return ProofDecision(verdict, None, comparison.sentence(words, spent), error, won)
    instead = "in place of those in force, " if role == "suspected" and state.active is not None else ""
    cure = f"; to take it back: incsvr effects withdraw {names[0]}" if step == "doubtful" else ""
    return ProofDecision(verdict, step, instead + comparison.sentence(words, spent) + cure, error, won)
