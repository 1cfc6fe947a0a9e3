"""Values by which a sensor marks that it has no measurement: −32.768 m/s of a DVL without bottom, 65.535, −9999, 0."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array

_ALL_ONES = {"127", "255", "32767", "32768", "65535", "2147483647", "2147483648", "4294967295"}
"""Digits of the largest numbers of one, two and four bytes, signed and not."""
MIN_APART = 10.0
"""How many times farther out than all others a value is that no sensor measured, though it comes exactly again."""
MAX_MARKS = 2
"""Marks of one sensor at most: the largest number and the smallest."""
MAX_MARKED_SHARE = 0.5
"""Share of a stream's values up to which they are marks: beyond, the others are the strange ones."""
LINEAR = ("surge", "sway", "heave")
"""The velocities that a Doppler log measures."""
MIN_DROP = 2.0
"""How many times larger than nearly all other steps one to or from a zero is that is a mark."""
MIN_DROPS = 3
"""Drops to zero and back from which on they are marks."""
MIN_VALUES = 20
"""Values by which a stream shows what it measures."""


def without_marks(name: str, values: Array, is_command: bool = False) -> tuple[Array, str | None]:
    """The values (n,) in the unit in which they were recorded, NaN in place of marks; and a note on these.

    A mark is an outermost value, comes exactly again, and all others are far within it, or it has the digits of the
    largest number of some bytes, or nines. A command repeats itself, and may pulse: its mark (`is_command`) needs them.
    """
    known = values[np.isfinite(values)]
    if known.size < MIN_VALUES:
        return values, None
    if name in LINEAR and (lost := _lost(values)).any():
        return np.where(lost, np.nan, values), (
            f"{name} drops to exactly 0 in {np.count_nonzero(lost)} of {known.size} samples, at once and back: they "
            "are left out as a sensor's mark of no measurement"
        )
    outer = np.abs(known) > 0.5 * np.max(np.abs(known))
    found, others = np.unique(known[outer]), np.abs(known[~outer])
    if found.size > MAX_MARKS or not others.any() or outer.sum() > MAX_MARKED_SHARE * known.size:
        return values, None
    count, ratio = int(outer.sum()), float(np.abs(found).min() / others.max())
    spelt = all(_is_mark(each) for each in found.tolist())
    repeats = not is_command and np.ptp(known[~outer]) > 0.0 and count > found.size and ratio >= MIN_APART
    if not (spelt or repeats):
        return values, None
    which = " or ".join(f"{each:g}" for each in found)
    return np.where(np.isin(values, found), np.nan, values), (
        f"{name} is {which} in {count} of {known.size} samples, {ratio:.2g} times farther out than all others: they "
        "are left out as a sensor's mark of no measurement"
    )


def _lost(values: Array) -> NDArray[np.bool_]:
    """(n,) whether a value is one of the zeros by which a Doppler log marks that it has lost the bottom.

    A motion passes zero by steps such as its others; from a mark of zero it comes back, several times, by larger ones.
    """
    places = np.flatnonzero(np.isfinite(values))
    known = values[places]
    zero = known == 0.0
    moves = np.abs(np.diff(known))[~zero[1:] & ~zero[:-1]]
    lost = np.zeros(values.size, dtype=np.bool_)
    if not zero.any() or moves.size < MIN_VALUES or zero.mean() > MAX_MARKED_SHARE:
        return lost
    edges = np.diff(np.concatenate(([0], zero.astype(np.int8), [0])))
    beside = np.concatenate(([0.0], np.abs(known), [0.0]))
    limit, spells = MIN_DROP * float(np.quantile(moves, 0.95)), 0
    for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        if max(beside[begin], beside[end + 1]) > limit:
            lost[places[begin:end]] = True
            spells += 1
    return lost if spells >= MIN_DROPS else np.zeros_like(lost)


def _is_mark(value: float) -> bool:
    """Whether a number has the digits of a mark."""
    digits = re.sub(r"[-.]", "", f"{abs(value):.10g}").strip("0")
    return digits in _ALL_ONES or (len(digits) > 2 and set(digits) == {"9"})
