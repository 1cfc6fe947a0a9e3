"""Whether the learner learns, as one value that health carries: learning, starved or paused.

starved: measurements come, and no sample can be made of them, or none that is evidence about damping. paused: samples
are made, and a check keeps them from being learned. Both say why in one sentence; the served model stays the last one
that was learned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["learning", "starved", "paused"]


@dataclass(frozen=True, slots=True)
class LearningState:
    """The state, the vehicle's time [s] since which it holds, and why in one sentence; empty while it learns."""

    state: State = "learning"
    since: float = 0.0
    why: str = ""

    @property
    def sentence(self) -> str:
        """The sentence for people."""
        return f"learning is {self.state}: {self.why}" if self.why else "learning"

    def now(self, paused: str | None, starved: str | None, t: float) -> LearningState:
        """The state at the vehicle's time t [s], given why learning is paused and why there is no evidence.

        A pause is said before a lack of samples: somebody decided it. `since` moves with the state alone.
        """
        state: State = "paused" if paused else "starved" if starved else "learning"
        return LearningState(state, self.since if state == self.state else t, paused or starved or "")
