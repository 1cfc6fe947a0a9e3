"""What explains the changes of one dive: which one cause moves all inertias and drags as they moved, others not at all.

A cause says which quantities share one factor; all others must stay. It is refused where their logarithms scatter about
that by more than their errors let them (χ², 5 %), the quantities taken as independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from incsvr.numerics import Array
from incsvr.vehicle.compare import Comparison, Quantity

REFUSED_P = 0.05
"""Chance of a scatter as large as this, below which a cause is refused."""


@dataclass(frozen=True, slots=True)
class Cause:
    """A cause that fits the changes of one dive.

    Attributes:
        what: in words.
        factor: by which its quantities changed.
        p_value: of a scatter as large, if it is the cause.
    """

    what: str
    factor: float
    p_value: float


def causes(compared: Comparison, dive: int) -> tuple[Cause, ...]:
    """The causes that fit what changed in a dive, the likeliest first; none where no single one does."""
    values = [row[dive] for row in compared.values]
    if any(value.reference is None for value in values):
        return ()
    columns = [(value.estimate, value.error, value.reference, value.reference_error) for value in values]
    now, error, before, before_error = np.array(columns, dtype=np.float64).T
    return fitting_causes(compared.quantities, now, error, before, before_error)


def fitting_causes(
    quantities: Sequence[Quantity], now: Array, error: Array, before: Array, before_error: Array
) -> tuple[Cause, ...]:
    """The causes that fit values (n,) now and before, with their standard errors, the likeliest first."""
    if min(now.min(), before.min()) <= 0.0:
        return ()
    moved, spread = np.log(now / before), (error / now) ** 2 + (before_error / before) ** 2
    found = [
        Cause(words.format(percent=_percent(factor, inverse)), factor, p_value)
        for words, inverse, together in _hypotheses(quantities)
        for factor, p_value in [_fitted(moved, spread, together)]
        if p_value > REFUSED_P and not (inverse and factor < 1.0)
    ]
    return tuple(sorted(found, key=lambda cause: -cause.p_value))


def _hypotheses(quantities: Sequence[Quantity]) -> list[tuple[str, bool, NDArray[np.bool_]]]:
    """Words of each cause, whether they name what is lost instead of what grew, and which quantities share its
    factor."""
    axes = list(dict.fromkeys(quantity.axis for quantity in quantities))
    kinds = np.array([quantity.kind for quantity in quantities])
    of = np.array([quantity.axis for quantity in quantities])
    found = []
    if len(axes) > 1:
        found.append(("all drags changed alike ({percent}), as by fouling or by its removal", False, kinds == "drag"))
        words = "all inertias and drags changed alike ({percent}), as if all efforts acted more weakly or more strongly"
        found.append((words, False, kinds != ""))
    for axis in axes:
        if np.count_nonzero(of == axis) > 1:
            words = f"inertia and drag of {axis} grew alike, as if {{percent}} of its effort were lost: a lost thruster"
            found.append((words, True, of == axis))
    found += [
        (f"the {quantity.axis} {quantity.kind} alone changed ({{percent}})", False, np.arange(of.size) == k)
        for k, quantity in enumerate(quantities)
    ]
    return found


def _fitted(moved: Array, spread: Array, together: NDArray[np.bool_]) -> tuple[float, float]:
    """The factor that some quantities share, and the chance of a scatter as large as that about it."""
    mean = float(np.average(moved[together], weights=1.0 / spread[together]))
    left = np.where(together, moved - mean, moved)
    return float(np.exp(mean)), float(chdtrc(moved.size - 1, np.sum(left**2 / spread)))


def _percent(factor: float, inverse: bool) -> str:
    return f"{100.0 * (1.0 - 1.0 / factor):.0f} %" if inverse else f"{100.0 * (factor - 1.0):+.0f} %"
