"""Values of a stream that came on a bus."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Values:
    """Values of one stream.

    Attributes:
        name: of the stream.
        t: (n,) stamps [s], n ≥ 1.
        value: (n,) in SI units.
        learnable: (n,) whether each may be learned from; None where all may.
    """

    name: str
    t: Array
    value: Array
    learnable: NDArray[np.bool_] | None = None

    def to_learn(self) -> Values | None:
        """Those that may be learned from; None without any."""
        if self.learnable is None or self.learnable.all():
            return self
        return Values(self.name, self.t[self.learnable], self.value[self.learnable]) if self.learnable.any() else None

    @staticmethod
    def joined(parts: Sequence[Values]) -> Values:
        """The parts of a stream as one."""
        may = [np.ones(part.t.size, dtype=bool) if part.learnable is None else part.learnable for part in parts]
        t, value = (np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "value"))
        return Values(parts[0].name, t, value, np.concatenate(may))
