"""Values of a stream, with their times and the order in which they came."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Values:
    """Values of a stream, or of a command.

    Attributes:
        t: (n,) stamps on the one clock [s], in any order.
        value: (n,) in SI units, of a command in the thruster's.
        order: (n,) in which they came: times of writing in a log [s], numbers of messages on a bus.
        learnable: (n,) whether each may be learned from.
    """

    t: Array
    value: Array
    order: Array
    learnable: NDArray[np.bool_]

    @staticmethod
    def of(t: Array, value: Array, order: Array | None = None) -> Values:
        """Values that all may be learned from; without another order they came as they stand."""
        came = np.arange(t.size, dtype=np.float64) if order is None else order
        return Values(t, value, came, np.ones(t.size, dtype=bool))

    def rows(self, wanted: NDArray[Any] | slice) -> Values:
        """The values where a mask is true, or at these places."""
        return Values(*(getattr(self, name)[wanted] for name in Values.__slots__))

    def to_learn(self) -> Values | None:
        """Those that may be learned from; None without any."""
        if self.learnable.all():
            return self
        return self.rows(self.learnable) if self.learnable.any() else None

    @staticmethod
    def joined(parts: Sequence[Values]) -> Values:
        """The parts of a stream as one."""
        return Values(*(np.concatenate([getattr(part, name) for part in parts]) for name in Values.__slots__))
