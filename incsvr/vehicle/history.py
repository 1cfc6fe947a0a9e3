"""Stored coefficients of many dives of many vehicles, compared without their logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.vehicle.changes import Changes, changes

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
        key = (self.vehicle * len(axes) + self.axis) * len(quantities) + self.quantity
        keys, series, counts = np.unique(key, return_inverse=True, return_counts=True)
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
        reference, spoilt, p_value = (
            each[series, rank] for each in (found.reference, found.reference_error, found.p_value)
        )
        return Changes(reference, spoilt, p_value, found.changed[series, rank])

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
