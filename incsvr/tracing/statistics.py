"""The statistics that both forms share: whitening, p-values, and the bootstrap of a change in error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from incsvr.numerics import Array

NORMAL_95 = 1.959964
"""Half width of a 95 % interval in deviations."""


@dataclass(frozen=True, slots=True)
class Change:
    """Change of an error from before to after, with its 95 % interval."""

    estimate: float
    low: float
    high: float

    def to_dict(self) -> dict[str, float]:
        return {"estimate": self.estimate, "low": self.low, "high": self.high}


def whitened(
    values: Array,
    starts: NDArray[np.intp],
    lags: int = 3,  # past values that whiten the present one
) -> Array:
    """(n,) values less what their own past tells; zero at the beginning of pieces, where there is none.

    Args:
        values: (n,) of cells.
        starts: (pieces + 1,) first cell of each piece, and the end.
    """

    def past(of: Array) -> Array:
        return np.stack([np.roll(of, k) for k in range(1, lags + 1)], axis=1)

    usable = np.ones(values.size, dtype=bool)
    for k in range(lags):
        usable[np.minimum(starts[:-1] + k, values.size - 1)] = False
    theta = np.linalg.lstsq(past(values)[usable], values[usable])[0]
    return np.where(usable, values - past(values) @ theta, 0.0)


def p_value(gain: float, freedom: int, looks: float) -> float:
    """χ² tail of a likelihood ratio, times the number of looks that the search took (Bonferroni), at most 1.

    The likelihood is that of whitened residuals, so that autocorrelation up to AR(3) is in it; S. S. Wilks, Ann. Math.
    Stat. 9 (1938).
    """
    return float(min(1.0, looks * chdtrc(max(freedom, 1), max(gain, 0.0))))


def change_of_rms(before: Sequence[Array], after: Sequence[Array], length: int, seed: int = 0) -> Change:
    """Change of the root mean square with a 95 % interval: moving-block bootstrap over paired errors.

    Args:
        before: errors of each held-out piece.
        after: the same instants.
        length: of a block [samples]; well above the errors' correlation time (H. R. Künsch, Ann. Stat. 17, 1989).
    """
    pieces = [(b**2, a**2) for b, a in zip(before, after, strict=True)]
    sums_before, sums_after, counts = [], [], []
    for b, a in pieces:
        size = min(length, b.size)
        total = np.concatenate([[0.0], np.cumsum(b)]), np.concatenate([[0.0], np.cumsum(a)])
        # overlapping blocks, at most a few hundred a piece
        first = np.unique(np.linspace(0, b.size - size, max(1, min(b.size - size + 1, 400))).astype(int))
        sums_before.append(total[0][first + size] - total[0][first])
        sums_after.append(total[1][first + size] - total[1][first])
        counts.append(np.full(first.size, float(size)))
    all_before, all_after, count = (np.concatenate(x) for x in (sums_before, sums_after, counts))
    weight = np.concatenate([np.full(c.size, b.size / c.size) for c, (b, _) in zip(counts, pieces, strict=True)])
    samples = sum(b.size for b, _ in pieces)
    draws = max(2, round(samples / float(np.mean(count))))
    index = np.random.default_rng(seed).choice(count.size, size=(2000, draws), p=weight / weight.sum())
    n = count[index].sum(axis=1)
    change = np.sqrt(all_after[index].sum(axis=1) / n) - np.sqrt(all_before[index].sum(axis=1) / n)
    estimate = rms(after) - rms(before)
    low, high = (float(q) for q in np.quantile(change, [0.025, 0.975]))
    return Change(estimate, min(low, estimate), max(high, estimate))


def rms(errors: Sequence[Array]) -> float:
    """Root mean square over all pieces together."""
    return float(np.sqrt(sum(float(e @ e) for e in errors) / max(sum(e.size for e in errors), 1)))
