"""Where live tracing stands, as a value: what is suspected, proven and in force, and what is to be done next.

    trace → suspected → proof on fresh data → promoted → tried again and again → withdrawn

That is `adopt`. Under `advise` a proof ends with `proven`, and an operator alone promotes and withdraws; so it is under
`adopt` with what an operator has withdrawn.

All times are the vehicle's. How far the data of a trace or a proof reach, and behind which batch their answer falls,
depends on the clock on the wall: on how quickly data came and how long the process took. What follows from an answer
does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

from incsvr.compensation.promotion import Verdict

FRESH_PART = 0.25
"""This part of the window comes between two traces: a process beside the learner is not always busy, and what came on
lately is in all of the window's newest half before three quarters of a window passed."""
TRIAL_PART = 0.5
"""A suspected effect is compared on all data since its trace, each time that `tracing.proof` more has come, until that
is this part of the window; then it has proven itself or is refused. What is in force is compared whenever so much is
fresh. Before the fresh data the models know the rest of the window."""
STANDING_BETS = 10
"""Sets of effects whose bets are remembered; those that were suspected longest ago go."""
STEPS = 60
"""Steps that the history keeps; the oldest go."""
RESIDUAL = "residual"
"""What a step is about that is about no effect."""

Content = Mapping[str, Any]
"""A trace, in the form that `incsvr trace --json` writes, as far as it is needed: `effects`, `model`, `loop`. With it
come `since`, the time from which on the data that it follows from begin [s], and `proof`, the last comparison on fresh
data with the time `until` that it reaches to."""
Work = Literal["trace", "prove"]
Role = Literal["suspected", "proven", "force"]
Mode = Literal["off", "advise", "adopt"]


@dataclass(frozen=True, slots=True)
class TracingState:
    """All that survives a restart.

    Attributes:
        force: the trace whose effects are in force.
        shadow: the trace whose effects are suspected.
        proven: the trace whose effects have proven themselves and wait for an operator.
        fresh: neither a trace nor a proof has seen what is younger than this [s].
        traced: the newest data of the last trace [s].
        suspicions: how many sets of effects were suspected: the chance that is spent on each becomes less.
        bets: of a set of effects, by its names, its number among those suspected, and ln of what betting on it won
            until now. What is suspected again goes on from there: its data are later ones each time, and what is won by
            one bet after another is multiplied.
        held: effects that an operator has withdrawn: nobody else promotes them again.
        history: every step, in the ledger's form.
    """

    force: Content | None = None
    shadow: Content | None = None
    proven: Content | None = None
    fresh: float = 0.0
    traced: float | None = None
    suspicions: int = 0
    bets: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    history: tuple[dict[str, Any], ...] = ()

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TracingState:
        """The standing whose `to_dict` gave `data`."""
        known = {name: data[name] for name in TracingState.__slots__ if name in data}  # an earlier version kept others
        listed = {name: tuple(known.get(name, ())) for name in ("held", "history")}
        bets = {name: (int(count), float(won)) for name, (count, won) in dict(known.get("bets", {})).items()}
        return TracingState(**{**known, **listed, "bets": bets})

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    @property
    def tried(self) -> tuple[Role, Content] | None:
        """The trace that the next proof is about: what is suspected, else what was compared longest ago."""
        if self.shadow is not None:
            return "suspected", self.shadow
        others: list[tuple[Role, Content]] = []
        if self.proven is not None:
            others.append(("proven", self.proven))
        if self.force is not None:
            others.append(("force", self.force))
        return min(others, key=lambda one: (one[1].get("proof") or {}).get("until", 0.0), default=None)

    def due(self, newest: float, window: float, proof: float) -> Work | None:
        """What is to be done now that a full window reaches up to `newest` [s].

        Effects are proven whenever enough is fresh. A trace begins where nothing is suspected, and sees something that
        the trace before has not seen.

        Args:
            newest: [s].
            window, proof: as configured [s].
        """
        if self.tried is not None and newest >= self.fresh + (proof if self.shadow else TRIAL_PART * window):
            return "prove"
        # What was found is only found again.
        rest = FRESH_PART * window if self.proven is None and self.force is None else window
        rested = self.traced is None or newest >= self.traced + rest
        return "trace" if self.shadow is None and rested else None

    def clock_began_anew(self, newest: float) -> TracingState:
        """Where the vehicle's clock stands before what was seen, all counts from now."""
        if newest >= max(self.fresh, self.traced or 0.0):
            return self
        return replace(self, fresh=newest, traced=None)

    def noted(self, step: Mapping[str, Any], about: Sequence[str] = (RESIDUAL,)) -> TracingState:
        """With a step in the history, about each of these."""
        steps = tuple({"effect": name, **step} for name in about)
        return replace(self, history=(*self.history, *steps)[-STEPS:])

    def after_trace(self, newest: float, found: Content | None) -> TracingState:
        """A trace of the data up to `newest` [s] ended; None where it found nothing that can be taken up."""
        if found is None:
            return replace(self, shadow=None, traced=newest)
        key = _key(found)
        count, won = self.bets.get(key, (self.suspicions + 1, 0.0))
        others = [(name, bet) for name, bet in self.bets.items() if name != key]
        bets = dict([*others[1 - STANDING_BETS :], (key, (count, won))])
        suspicions = max(count, self.suspicions)
        return replace(self, shadow=found, traced=newest, fresh=newest, suspicions=suspicions, bets=bets)

    @property
    def stake(self) -> tuple[int, float]:
        """Of what is suspected: its number among those suspected, and ln of what earlier bets on it won."""
        return (1, 0.0) if self.shadow is None else self.bets.get(_key(self.shadow), (max(self.suspicions, 1), 0.0))

    def overdue(self, newest: float, window: float) -> bool:
        """Whether half a window passed since the trace of what is suspected: the data before it are going, and a proof
        that could not be made by then cannot be made."""
        return self.shadow is not None and newest >= float(self.shadow.get("until", newest)) + TRIAL_PART * window

    def after_proof(
        self, newest: float, verdict: Verdict, compared: Mapping[str, Any] | None = None, won: float = 0.0
    ) -> TracingState:
        """A proof of what is tried, on data up to `newest` [s], ended.

        Args:
            compared: what it is in plain words.
            won: ln of what was won by bets on these data.
        """
        if self.tried is None:
            return self
        role, content = self.tried
        seen = content if compared is None else {**content, "proof": {**compared, "until": newest}}
        on = replace(self, fresh=newest)
        match role, verdict:
            case "suspected", "promoted":
                return replace(on, force=seen, shadow=None, bets=self._bets_without(content))
            case "suspected", "proven":
                return replace(on, proven=seen, shadow=None, bets=self._bets_without(content))
            case "suspected", "refused":
                count, before = self.stake
                # with less than it began with, a new bet is the better one: it is counted anew
                kept = {_key(content): (count, before + won)} if before + won > 0.0 else {}
                return replace(on, shadow=None, bets={**self._bets_without(content), **kept})
            case "suspected", _:
                return replace(on, shadow=seen)
            case "proven", "withdrawn":
                return replace(on, proven=None)
            case "proven", _:
                return replace(on, proven=seen)
            case _, "withdrawn":
                return replace(on, force=None)
            case _, _:
                return replace(on, force=seen)

    def _bets_without(self, content: Content) -> dict[str, tuple[int, float]]:
        return {name: bet for name, bet in self.bets.items() if name != _key(content)}

    def promoted(self, role: Role) -> TracingState:
        """An operator has promoted what is suspected or proven."""
        chosen = self.shadow if role == "suspected" else self.proven
        if chosen is None:
            return self
        names = {str(finding["effect"]) for finding in chosen["effects"]}
        left = replace(self, shadow=None) if role == "suspected" else replace(self, proven=None)
        return replace(left, force=chosen, held=tuple(name for name in self.held if name not in names))

    def withdrawn(self, names: Sequence[str]) -> TracingState:
        """An operator has withdrawn what is in force, these effects."""
        return replace(self, force=None, held=tuple(dict.fromkeys((*self.held, *names))))


def _key(content: Content) -> str:
    """The names of the effects of a trace."""
    return ", ".join(sorted(str(finding["effect"]) for finding in content["effects"]))
