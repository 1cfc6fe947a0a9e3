"""Stored coefficients of many dives of many vehicles, compared without their logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.vehicle.changes import Changes, changes, determined
from incsvr.vehicle.shown import Shown, not_determined, places, unit_of

Codes = NDArray[np.int64]
SAME_SPEED = 0.01
"""Relative difference of speeds up to which drags are compared: the drag itself differs by up to twice as much."""


@dataclass(frozen=True, slots=True)
class History:
    """Coefficients, a row each, dives in their order.

    Attributes:
        vehicle, axis, quantity: (n,) codes of what each row is of, and `names` of each: the texts of the codes.
        names: texts of the codes of vehicles, axes and quantities.
        speed: (n,) at which a drag is taken [m/s] or [rad/s]; 0 of an inertia.
        estimate, error, freedom: (n,) with standard errors and their degrees of freedom.
    """

    vehicle: Codes
    axis: Codes
    quantity: Codes
    names: tuple[Sequence[str], Sequence[str], Sequence[str]]
    speed: Array
    estimate: Array
    error: Array
    freedom: Array

    def changes(self) -> Changes:
        """The test of change of every row, (n,) each: every quantity of every vehicle against its own past.

        Raises:
            BadInput: drags of one axis are given at several speeds.
        """
        vehicles, axes, quantities = self.names
        keys, series, counts = self._series()
        self._refuse_several_speeds(series, keys.size)
        order = np.argsort(series, kind="stable")
        rank = np.empty(series.size, dtype=np.int64)
        rank[order] = np.arange(series.size) - np.repeat(np.cumsum(counts) - counts, counts)
        whole = (keys.size, int(counts.max()))

        def spread(column: Array) -> Array:
            found = np.full(whole, np.nan)
            found[series, rank] = column
            return found

        owner = keys // (len(axes) * len(quantities))
        share = 1.0 / np.bincount(owner, minlength=len(vehicles))[owner]
        found = changes(spread(self.estimate), spread(self.error), spread(self.freedom), share)
        reference, spoilt, p_value, smallest = (
            each[series, rank] for each in (found.reference, found.reference_error, found.p_value, found.smallest)
        )
        return Changes(reference, spoilt, p_value, found.changed[series, rank], smallest)

    def shown(self, found: Changes, dives: Sequence[Any]) -> list[Shown]:
        """The smallest change of each quantity of each vehicle that would have been seen, given the test of change.

        Args:
            dives: the name of each row's dive.
        """
        keys, series, counts = self._series()
        known = determined(self.estimate, self.error, self.freedom)
        number = np.bincount(series, weights=known).astype(np.int64).tolist()
        vehicles, axes, quantities = self.names
        shown = []
        for k, row in enumerate(places(series, found.smallest, known).tolist()):
            key, quantity = divmod(int(keys[k]), len(quantities))
            vehicle, axis = divmod(key, len(axes))
            unit = unit_of(axes[axis], quantities[quantity])
            what = f"{vehicles[vehicle]} {axes[axis]} {quantities[quantity]}"
            if row < 0:
                shown.append(Shown(what, unit, why=not_determined(number[k], int(counts[k]))))
            else:
                change, before = float(found.smallest[row]), float(found.reference[row])
                shown.append(Shown(what, unit, str(dives[row]), change, before))
        return shown

    def _series(self) -> tuple[Codes, NDArray[np.intp], Codes]:
        """The key of each quantity of each vehicle, the place of each row's key among them, and the rows of each."""
        _, axes, quantities = self.names
        key = (self.vehicle * len(axes) + self.axis) * len(quantities) + self.quantity
        return np.unique(key, return_inverse=True, return_counts=True)

    def _refuse_several_speeds(self, series: NDArray[np.intp], count: int) -> None:
        """Refuses drags that were taken at different speeds."""
        fastest, slowest = np.zeros(count), np.full(count, np.inf)
        np.maximum.at(fastest, series, self.speed)
        np.minimum.at(slowest, series, self.speed)
        apart = np.flatnonzero(fastest > slowest * (1.0 + SAME_SPEED))
        if apart.size:
            row = int(np.flatnonzero(series == apart[0])[0])
            vehicles, axes, _ = self.names
            raise BadInput(
                f"{vehicles[self.vehicle[row]]}: its {axes[self.axis[row]]} drag is given at several speeds, "
                f"{slowest[apart[0]]:.3g} to {fastest[apart[0]]:.3g}; write all its dives with one `incsvr compare`"
            )
