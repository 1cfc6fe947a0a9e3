"""Values that are far from their stream's clock: held until it is known whether the clock is where they say."""

from __future__ import annotations

from math import inf

from incsvr.signals.steps import MIN_STEP_S

MAX_DOUBTED_VALUES = 1000
"""Values that are doubted at most."""


class DoubtedStamps:
    """The doubted values of one stream, in the order of their arrival."""

    def __init__(self, values: list[tuple[float, float]] | None = None, advanced: int = 0) -> None:
        self.values = [] if values is None else values
        self.advanced = advanced
        """The number of stamps that were later than all before them."""

    def __len__(self) -> int:
        return len(self.values)

    def has(self, time: float) -> bool:
        """Whether a value with this stamp [s] is among them: the same again proves nothing."""
        return any(abs(stamp - time) < MIN_STEP_S for stamp, _ in self.values)

    def followed_by(self, time: float, lateness: float, pause: float) -> bool:
        """Whether a value with this stamp [s] may be of the same clock, after a pause [s] of at most so long; with none
        before it, it is."""
        newest = self._newest() if self.values else time
        return len(self.values) < MAX_DOUBTED_VALUES and newest - lateness <= time <= newest + pause

    def add(self, time: float, value: float) -> None:
        self.advanced += time > self._newest()
        self.values.append((time, value))

    def take(self) -> list[tuple[float, float]]:
        """Removes and returns all values, in the order of their stamps."""
        values = sorted(self.values)
        self.values, self.advanced = [], 0
        return values

    def _newest(self) -> float:
        return max((stamp for stamp, _ in self.values), default=-inf)
