"""The number of lost messages of a stream, by the numbers that their sender gave them.

Messages may come out of order. A number is lost when two messages after it came and it has not; one that comes later
still is found again. Numbers that begin anew (the sender was restarted) are followed.
"""

from __future__ import annotations

MAX_MISSING = 4096
"""Missing numbers that are remembered; those of a larger gap cannot be found again."""


class Sequence:
    """The numbers of one stream."""

    def __init__(self) -> None:
        self._highest: int | None = None
        self._last = 0
        self._missing: dict[int, None] = {}  # in their order
        self._overtaken = 0  # missing numbers that only the latest message has overtaken
        self._lost = 0  # and not remembered any more

    @property
    def lost(self) -> int:
        """Messages that have not come."""
        return self._lost + len(self._missing) - self._overtaken

    def add(self, number: int) -> None:
        """A message with this number came."""
        highest, self._overtaken = self._highest, 0
        again = highest is not None and number <= highest and number not in self._missing
        if highest is None or (again and (number == self._last + 1 or number < highest - MAX_MISSING)):
            self._begin(number)
        elif number > highest:
            first = max(highest + 1, number - MAX_MISSING)
            self._lost += first - highest - 1
            self._missing.update(dict.fromkeys(range(first, number)))
            while len(self._missing) > MAX_MISSING:
                del self._missing[next(iter(self._missing))]
                self._lost += 1
            self._overtaken, self._highest = number - first, number
        else:
            self._missing.pop(number, None)
        self._last = number

    def _begin(self, number: int) -> None:
        """The first number, or the first after the sender began anew."""
        self._lost += len(self._missing)
        self._missing.clear()
        self._highest = number
