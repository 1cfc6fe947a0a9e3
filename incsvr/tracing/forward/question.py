"""What is asked of which recordings, and the price of each effect's parameters.

    (free parameters) · ln(duration / 0.1 T_c) + 2 ln(values tried),

Schwarz's criterion with the number of independent moments of a motion of time scale T_c for its n, and Bonferroni's
correction for the search within the candidate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.effects import Effect
from incsvr.tracing.forward.candidates import starts
from incsvr.tracing.forward.equations import Part, columns
from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.projection import Projection


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked of which recordings.

    Attributes:
        grid: the recordings as cells.
        effects: that may be named.
        prices: by the effect's key, what its parameters cost in 2 Δℓ.
    """

    grid: Grid
    effects: tuple[Effect, ...]
    prices: Mapping[str, float]

    @staticmethod
    def of(grid: Grid, effects: Sequence[Effect], base: Fit) -> Question:
        """The question whether these effects are missing beside `base`, the fit without any."""
        s = Projection(grid, base).signals
        moments = np.log(max(len(s) * grid.cell / (0.1 * s.scale), 2.0))
        prices = {}
        for effect in effects:
            begun = list(starts(effect, s))
            if begun:
                linear = 0 if begun[0].thrust else columns(begun[0], s).shape[0]
                free = linear + (1 if begun[0].searched else 0) + (1 if effect.shapes else 0)
                prices[effect.key] = free * float(moments) + 2.0 * float(np.log(len(begun)))
        return Question(grid, tuple(effect for effect in effects if effect.key in prices), prices)

    def price(self, part: Part) -> float:
        return self.prices[part.effect.key]
