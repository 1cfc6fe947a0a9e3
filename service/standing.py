"""Where live tracing stands, as a value: which effects are in force, which run in shadow, what is to be done next.

    residual no longer white → trace → shadow → proof on fresh data → promoted → tried again and again → withdrawn

All times are the vehicle's. How far the data of a trace or a proof reach, and behind which batch their answer falls,
depends on the clock on the wall: on how quickly data came and how long the process took. What follows from an answer
does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from incsvr.verdict import Verdict

LEVEL = 1e-3
"""Below this p-value the residual is not white. One look in a thousand is a false alarm, which costs a trace: a window
of 900 s is looked at thirty times, but those looks share most of their data."""
STEPS = 60
"""Steps that the history keeps; the oldest go."""
RESIDUAL = "residual"
"""What a step is about that is about no effect."""

Content = Mapping[str, Any]
"""A trace, in the form that `incsvr trace --json` writes, as far as it is needed: `effects` and `model`."""
Work = Literal["trace", "prove"]


@dataclass(frozen=True, slots=True)
class Standing:
    """All that survives a restart.

    Attributes:
        force: the trace whose effects are in force.
        shadow: the trace whose effects are on trial.
        fresh: neither a trace nor a proof has seen what is younger than this [s].
        traced: the newest data of the last trace [s].
        doubted: whether the effects in force brought nothing the last time.
        history: every step, in the ledger's form.
    """

    force: Content | None = None
    shadow: Content | None = None
    fresh: float = 0.0
    traced: float | None = None
    doubted: bool = False
    history: tuple[dict[str, Any], ...] = ()

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Standing:
        """The standing whose `to_dict` gave `data`."""
        return Standing(**{**data, "history": tuple(data["history"])})

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    @property
    def tried(self) -> Content | None:
        """The trace that the next proof is about."""
        return self.force if self.shadow is None else self.shadow

    def due(self, newest: float, p: float, window: float, proof: float) -> Work | None:
        """What is to be done now that a full window reaches up to `newest` [s].

        Effects are proven whenever `proof` seconds are fresh. A trace begins where the residual is not white, and sees
        nothing that the trace before has seen: coloured water would keep a process busy for nothing.

        Args:
            newest: [s].
            p: of the residual's being white.
            window, proof: as configured [s].
        """
        if self.tried is not None and newest >= self.fresh + proof:
            return "prove"
        rested = self.traced is None or newest >= self.traced + window
        return "trace" if self.shadow is None and p < LEVEL and rested else None

    def clock_began_anew(self, newest: float) -> Standing:
        """Where the vehicle's clock stands before what was seen, all counts from now."""
        if newest >= max(self.fresh, self.traced or 0.0):
            return self
        return replace(self, fresh=newest, traced=None)

    def noted(self, t: float, step: str, why: str, about: Sequence[str] = (RESIDUAL,)) -> Standing:
        """With a step in the history."""
        steps = tuple({"effect": name, "step": step, "why": why, "t": t} for name in about)
        return replace(self, history=(*self.history, *steps)[-STEPS:])

    def after_trace(self, newest: float, found: Content | None) -> Standing:
        """A trace of the data up to `newest` [s] ended; None where it found nothing that can be taken up."""
        return replace(self, shadow=found, traced=newest, fresh=newest if found is not None else self.fresh)

    def after_proof(self, newest: float, verdict: Verdict) -> Standing:
        """A proof on data up to `newest` [s] ended."""
        on = replace(self, fresh=newest, doubted=verdict == "doubted")
        if verdict == "promoted":
            return replace(on, force=self.shadow, shadow=None)
        if verdict == "refused":
            return replace(on, shadow=None, doubted=self.doubted)
        if verdict == "withdrawn":
            return replace(on, force=None)
        return on
