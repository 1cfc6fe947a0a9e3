"""Whether an axis may be taken by itself: what other velocities take of its torque, as far as samples show it.

The paper's condition for Eq. 5 of one axis is that coupled terms are small. Without a mass matrix their size is told by
regression: y = τ − I ṙ on r and r|r|, and then, one after the other, on the products of velocities that push along this
axis (C(ν) ν) and the accelerations of the others (M off its diagonal).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, independent_share, root_mean_square
from incsvr.plant.axes import Axis, accelerating, products
from incsvr.plant.body import Motion

SMALL_RMS_SHARE = 0.15
"""Share of the torque's RMS up to which the neglected terms are small: thrust is rarely known to better."""
CLEAR_F = 20.0
"""F of a term on which the residual's independent samples agree: of some twenty terms one by chance in ten thousand."""
MAX_TERMS = 3
"""Terms that are told; a fourth has never mattered beside them."""
MIN_SAMPLES = 50
"""Samples below which nothing is said."""


@dataclass(frozen=True, slots=True)
class NeglectedTerms:
    """The torque of other velocities on an axis.

    Attributes:
        terms: as people read them, the largest first.
        rms: of what they take together [N m].
        torque: RMS of the torque [N m].
    """

    terms: tuple[str, ...]
    rms: float
    torque: float

    @property
    def share(self) -> float:
        return self.rms / self.torque


def neglected_terms(axis: Axis, rate: Array, damping: Array, torque: Array, motion: Motion) -> NeglectedTerms | None:
    """The torque of the other velocities, if it is significant and not small; else None.

    Args:
        axis: whose samples they are.
        rate, damping, torque: (n,) r [rad/s], τ − I ṙ and τ [N m].
        motion: of each other velocity its values and its accelerations (n,) each, NaN where they are not known.
    """
    terms = _terms(axis, rate, motion)
    known = np.all([np.isfinite(values) for values in terms.values()], axis=0) if terms else np.zeros(0, dtype=bool)
    count, level = int(known.sum()), root_mean_square(torque[known]) if known.any() else 0.0
    if count < MIN_SAMPLES or level == 0.0:
        return None
    own = np.column_stack([rate, rate * np.abs(rate), np.ones(rate.size)])[known]
    columns = {name: values[known] for name, values in terms.items() if np.ptp(values[known]) > 0.0}
    y = damping[known]
    chosen: list[str] = []
    design, left = own, _left(own, y)
    while len(chosen) < MAX_TERMS and len(chosen) < len(columns):
        rest = {name: _left(np.column_stack([design, columns[name]]), y) for name in columns if name not in chosen}
        best = min(rest, key=lambda name: float(rest[name] @ rest[name]))
        better = rest[best]
        power = max(float(better @ better), 1e-300)
        worth = count * independent_share(better)
        if worth * (float(left @ left) - power) / power < CLEAR_F:
            break
        chosen.append(best)
        design, left = np.column_stack([design, columns[best]]), better
    if not chosen:
        return None
    weights = np.linalg.lstsq(design, y, rcond=None)[0][own.shape[1] :]
    taken = design[:, own.shape[1] :] @ weights
    rms = root_mean_square(taken)
    return NeglectedTerms(tuple(chosen), rms, level) if rms > SMALL_RMS_SHARE * level else None


def _terms(axis: Axis, rate: Array, motion: Motion) -> dict[str, Array]:
    """(n,) each: products that push along the axis, and accelerations of the other velocities."""
    values = {axis.rate: rate} | {name: value for name, (value, _) in motion.items()}
    found = {f"{a}*{b}": values[a] * values[b] for a, b in products(axis, tuple(motion))}
    changes = accelerating(axis, tuple(motion))
    return found | {f"the change of channel {name}": motion[name][1] for name in changes}


def _left(design: Array, y: Array) -> Array:
    return np.asarray(y - design @ np.linalg.lstsq(design, y, rcond=None)[0])
