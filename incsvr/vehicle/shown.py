"""What a comparison of dives could have shown: the smallest change of each quantity, or why it could show none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.axes import AXES


@dataclass(frozen=True, slots=True)
class Shown:
    """The smallest change of one quantity that its dives would have shown.

    Attributes:
        what: the quantity, in words.
        unit: of its values.
        dive: in which dive the smallest change would have been found; None where the dives cannot show a change.
        change, reference: that change, and the mean of the dives before it; None likewise.
        why: why the dives cannot show a change; empty where they can.
    """

    what: str
    unit: str
    dive: str | None = None
    change: float | None = None
    reference: float | None = None
    why: str = ""

    @property
    def sentence(self) -> str:
        """For people."""
        if self.change is None or self.reference is None:
            return f"these dives cannot show a change of {self.what}: {self.why}"
        percent = 100.0 * self.change / abs(self.reference) if self.reference else np.inf
        return (
            f"the smallest change of {self.what} that would have been seen is {self.change:.3g} {self.unit} "
            f"({percent:.0f} % of {self.reference:.3g}), in {self.dive}"
        )

    def to_dict(self) -> dict[str, Any]:
        return {
            "quantity": self.what, "unit": self.unit, "smallest_change": self.change, "reference": self.reference,
            "dive": self.dive, "why_none": self.why or None,
        }  # fmt: skip


def unit_of(axis: str, quantity: str) -> str:
    """The unit of an inertia or a drag."""
    along = AXES[axis].along if axis in AXES else False
    return ("kg" if along else "kg m²") if quantity == "inertia" else ("N" if along else "N m")


def not_determined(number: int, dives: int) -> str:
    """Why nothing is known of a quantity that `number` of the dives determine."""
    return f"its 95 % interval is wider than its value in {dives - number} of {dives} dives"


def places(series: NDArray[np.intp], smallest: Array, known: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Of each series (0, 1, …) the row with the smallest change that it would have shown; −1 where fewer than two rows
    are known."""
    size = np.where(known & np.isfinite(smallest), smallest, np.inf)
    order = np.lexsort((size, series))
    first = order[np.searchsorted(series[order], np.arange(series.max() + 1))]
    enough = np.bincount(series, weights=known) >= 2.0
    return np.where(enough & np.isfinite(size[first]), first, -1)
