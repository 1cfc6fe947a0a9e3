"""Values by which a sensor marks that it has no measurement: −32.768 m/s of a DVL without bottom, 65.535, −9999."""

from __future__ import annotations

import re

import numpy as np

from incsvr.numerics import Array

_ALL_ONES = {"127", "255", "32767", "32768", "65535", "2147483647", "2147483648", "4294967295"}
"""Digits of the largest numbers of one, two and four bytes, signed and not."""
MIN_APART = 10.0
"""How many times farther out than all others a value is that no sensor measured, though it comes exactly again."""
MAX_MARKS = 2
"""Marks of one sensor at most: the largest number and the smallest."""
MAX_MARKED_SHARE = 0.5
"""Share of a stream's values up to which they are marks: beyond, the others are the strange ones."""
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


def _is_mark(value: float) -> bool:
    """Whether a number has the digits of a mark."""
    digits = re.sub(r"[-.]", "", f"{abs(value):.10g}").strip("0")
    return digits in _ALL_ONES or (len(digits) > 2 and set(digits) == {"9"})
