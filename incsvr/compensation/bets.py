"""Bets on the better of two forecasts of the same data: evidence that may be read at any time.

The data are cut into blocks. g is by how much log-likelihood the second forecast beats the first in a block, each
foretelling every value from what came before it. Somebody who holds that the second is no better offers a bet on
tanh(g/2), which lies between −1 and 1, at even odds; we stake a fixed fraction of what we have on each block:

    W ← W (1 + λ x),  x = tanh(g/2),    W = 1 at first,    the mean over several λ.

Where the first forecast is right, E[exp g | past] = 1, and tanh(g/2) = (e^g − 1)/(e^g + 1) is concave in e^g and zero
at 1, so that E[tanh(g/2) | past] ≤ 0 (Jensen). It is ≤ 0, too, where the first is wrong but the second no better by
this score. Then W is a nonnegative supermartingale, and the chance that it ever reaches 1/α, however long it runs and
however often it is looked at, is at most α (J. Ville, 1939; A. Ramdas et al., Statistical Science 38, 2023). A block
full of outliers counts as one lost or won bet. Forecasts that whiten the water leave nothing that lasts from block to
block; what lasts within one is in g.
"""

from __future__ import annotations

import math

import numpy as np

from incsvr.numerics import Array

STAKE_FRACTIONS = (0.05, 0.2, 0.5, 0.9)
"""λ: for effects that show little by little, and for those that show in every block."""


def score(gains: Array) -> Array:
    """(n,) x of each block from its g."""
    return np.asarray(np.tanh(0.5 * gains))


def wealth(scores: Array) -> Array:
    """(n,) ln W after each block.

    Args:
        scores: (n,) x of each block, between −1 and 1.
    """
    stakes = np.array(STAKE_FRACTIONS)[:, None]
    grown = np.cumsum(np.log1p(stakes * scores), axis=1)
    return np.asarray(np.logaddexp.reduce(grown, axis=0) - math.log(len(STAKE_FRACTIONS)))


def evidence(*scores: Array) -> float:
    """ln of the largest W that was reached, at least 0, where what we have is divided evenly among several scores."""
    return max(max(float(np.max(wealth(each), initial=0.0)) for each in scores) - math.log(len(scores)), 0.0)


def final_log_wealth(scores: Array) -> float:
    """ln of the W that is there at the end: later bets on the same may go on from it."""
    return float(wealth(scores)[-1]) if scores.size else 0.0
