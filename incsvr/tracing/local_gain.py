"""Does the thrust answer its command with one gain throughout, or less in spells?

A thruster that drops out for some seconds leaves a residual that lasts as long as a command does. Whitening takes that
for the noise's colour, and the innovations are no louder than elsewhere. But beside the whitened torque they show it:
in those spells the two go together.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, robust_deviation
from incsvr.tracing.thresholds import (
    GAIN_STANDARD_ERRORS,
    MAX_NAMED_SPELLS,
    PERMUTATIONS,
    RELEVANT_GAIN_DEVIATION,
    SPELL_P_VALUE,
    SPELL_WINDOW_SCALES,
)


def uneven_gain(innovation: Array, torque: Array, per_scale: float, seed: int = 0) -> NDArray[np.bool_]:
    """(n,) which innovations lie where the gain differs, where it differs more than chance would have it; else none.

    The squared gains of windows, each weighed by its information, against those beside circularly shifted torques: a
    shift leaves torque and noise as they are and takes away what the one owes to the other. That holds in open loop.

    Args:
        innovation: (n,) of the residual, white.
        torque: (n,) through the same filter.
        per_scale: innovations in a time scale of the motion.
    """
    nowhere = np.zeros(innovation.size, dtype=bool)
    length = max(round(0.5 * SPELL_WINDOW_SCALES * per_scale), 8)
    count = innovation.size // length
    if count < 8 or not np.any(torque):
        return nowhere
    usual = robust_deviation(innovation)
    e = np.clip(innovation, -6.0 * usual, 6.0 * usual)[: count * length]
    m = torque[: count * length]
    information = (m**2).reshape(count, length).sum(axis=1)
    known = information > 0.1 * float(np.mean(information))

    def gains(shifted: Array) -> Array:
        pull = (shifted * m).reshape(count, length).sum(axis=1)
        return np.asarray(np.where(known, pull / np.maximum(information, 1e-300), 0.0))

    def spread(found: Array) -> float:
        return float(information @ found**2)

    found, random = gains(e), np.random.default_rng(seed)
    shifts = random.integers(length, e.size - length, PERMUTATIONS)
    chance = np.array([spread(gains(np.roll(e, shift))) for shift in shifts])
    if (1 + np.sum(chance >= spread(found))) / (PERMUTATIONS + 1) > SPELL_P_VALUE:
        return nowhere
    deviation = np.sqrt(max(spread(found) - float(np.mean(chance)), 0.0) / float(information.sum()))
    if deviation < RELEVANT_GAIN_DEVIATION:
        return nowhere
    error = np.sqrt(float(np.mean(chance)) / max(int(known.sum()), 1) / np.maximum(information, 1e-300))
    inside = nowhere.copy()
    inside[: count * length] = np.repeat(known & (np.abs(found) > GAIN_STANDARD_ERRORS * error), length)
    return inside


def sentence(found: Sequence[tuple[float, float]]) -> str:
    """The sentence on an uneven gain, for people."""
    where = ", ".join(f"{a:.4g}–{b:.4g} s" for a, b in found[:MAX_NAMED_SPELLS])
    more = f" and {len(found) - MAX_NAMED_SPELLS} more" if len(found) > MAX_NAMED_SPELLS else ""
    return (
        f"the gain from command to thrust is not constant: it differs at {where}{more}; check the thrusters, the "
        "supply voltage and other loads there"
    )
