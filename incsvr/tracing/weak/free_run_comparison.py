"""How two free runs are compared, piece by piece: by their errors as they are, and by what the noise makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise_autocorrelation import DEGREES
from incsvr.tracing.weak.weak_form import split
from incsvr.tracing.weak.whitening import fit, jump_noise_factor, whiten

FEWEST_MEANS = 8
"""Blocks of a piece, below which its noise is not told."""


def gained(gain: Array) -> bool:
    """Whether the gains of the pieces, (pieces,), exceed their standard error in the mean.

    Or whether so many of eight or more pieces gained that a coin would do it once in twenty times: one piece that runs
    away where the fit had seen no such rates does not outweigh all others.
    """
    if gain.size and gain.mean() > gain.std() / np.sqrt(gain.size):
        return True
    return bool(gain.size >= 8 and np.mean(gain > 0.0) > 0.5 + 0.85 / np.sqrt(gain.size))


def likelier(before: Sequence[Array], after: Sequence[Array], mistimed: Sequence[Array], period: float) -> Array:
    """(pieces,) 2 Δℓ of free-run errors, as their means over blocks tell it: the gyro's noise is none of the model.

    The noise is that of `after`: an AR(3) with Student-t innovations, which are larger where the command jumps, for
    within a sample nobody knows when.

    Args:
        before: (blocks,) error of each piece with the one model [rad/s].
        after: the same with the other.
        mistimed: (blocks,) of each piece, as `Blocks` has it.
        period: of a block [s].
    """
    pieces = [k for k, error in enumerate(after) if error.size > FEWEST_MEANS]
    if not pieces:
        return np.zeros(0)
    means = split(np.cumsum([0, *(after[k].size for k in pieces)]).astype(np.intp), 1, period)

    def joined(values: Sequence[Array]) -> Array:
        return np.concatenate([values[k] for k in pieces])[means.first]

    old, new, jumps = (joined(x) for x in (before, after, mistimed))
    means = replace(means, mistimed=jumps)
    noise = fit(new, np.zeros((new.size, 0)), means)
    usual = noise.scale * jump_noise_factor(noise, means)

    def unlikely(errors: Array) -> Array:
        surprise: Array = (DEGREES + 1.0) * np.log1p((whiten(errors, noise.ar, means) / usual) ** 2 / DEGREES)
        return surprise

    piece = np.searchsorted(means.start, means.with_history, side="right") - 1
    gain = np.bincount(piece, weights=unlikely(old) - unlikely(new), minlength=len(pieces))
    return gain.astype(np.float64)
