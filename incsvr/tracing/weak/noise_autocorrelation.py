"""The colour of the noise: an AR(3) by Burg's method, and by weights where the command jumps.

Source: J. P. Burg, "Maximum entropy spectral analysis" (1975).
"""

from __future__ import annotations

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.weak.weak_form import Blocks

DEGREES = 6.0
"""ν of the innovations: outliers of a few per cent cost nothing, Gaussian noise costs 4 % of the efficiency."""

PASSES = 4
"""Of the weights: a fifth moves no coefficient by a hundredth."""


def burg(residual: Array, blocks: Blocks, jump_noise: float = 0.0, order: int = 3) -> Array:
    """AR coefficients of `residual`, pooled over the runs; outliers are drawn in to four deviations first.

    What the instant of a jump adds to its block is no part of the colour: there the residual is drawn in by as much.
    """
    residual = residual / np.sqrt(1.0 + jump_noise * np.square(blocks.mistimed))
    limit = 4.0 * max(1.4826 * _median(np.abs(residual[blocks.used])), 1e-12)
    forward = np.where(blocks.used, np.clip(residual, -limit, limit), 0.0)
    backward = forward.copy()
    ar = np.zeros(0)
    for k in range(1, order + 1):
        f, b = forward[1:], backward[:-1]
        for first in blocks.start[1:-1] - k:  # a run's first k blocks have no k predecessors
            f[max(first, 0) : first + k] = b[max(first, 0) : first + k] = 0.0
        power = float(f @ f + b @ b)
        reflection = 2.0 * float(f @ b) / power if power > 0.0 else 0.0
        ar = np.concatenate([ar - reflection * ar[::-1], [reflection]])
        forward, backward = f - reflection * b, b - reflection * f
    return ar


def autoregression(residual: Array, blocks: Blocks, jump_noise: float) -> Array:
    """AR coefficients of `residual` by Burg's method; where most jumps of the command are louder than the noise, by
    least squares with the weights of the innovations from it on.

    The instant of a jump stands in its own block and in what predicts the next three: the weights drop all four. What
    it adds is an error in what predicts, too, and draws the colour to white: it weighs once more. With nothing so loud
    the weights would tell the colour of calm water alone, where the noise is now strong, now weak.
    """
    ar = burg(residual, blocks, jump_noise)
    jumped = blocks.mistimed[blocks.mistimed > 0.0]
    if not jumped.size or jump_noise * _median(jumped) ** 2 < 1.0:
        return ar
    here, before = with_history(residual, blocks), np.stack([_earlier(residual, blocks, k) for k in (1, 2, 3)])
    scale = 0.0
    for _ in range(PASSES):
        innovation, level = here - ar @ before, 1.0 + jump_noise * jump_variance(ar, blocks)
        scale = scale or 1.4826 * _median(np.abs(innovation) / np.sqrt(level)) + 1e-300
        weight = (DEGREES + 1.0) / (DEGREES * level + np.square(innovation / scale))
        scale = scale_of(weight, innovation)
        weighted = before * (weight / level)
        normal = weighted @ before.T
        found = np.linalg.solve(normal + (1e-12 * np.trace(normal) + 1e-300) * np.eye(3), weighted @ here)
        if not fades(found):
            break
        ar = found
    return ar


def fades(ar: Array) -> bool:
    """Whether a noise of this colour dies away: every reflection of its lattice is below one (Levinson, backwards)."""
    while ar.size:
        last = float(ar[-1])
        if not abs(last) < 1.0:
            return False
        ar = (ar[:-1] + last * ar[:-1][::-1]) / (1.0 - last**2)
    return True


def jump_variance(ar: Array, blocks: Blocks) -> Array:
    """(m,) variance that jumps a sample period too early or late, in its block and the three before, add [(N m)²]."""
    square = np.square(blocks.mistimed)
    added: Array = square[blocks.with_history] + np.square(ar) @ square[blocks.previous]
    return added


def scale_of(weight: Array, innovation: Array) -> float:
    """s of weighted innovations."""
    return float(np.sqrt(float((weight * innovation) @ innovation) / innovation.size + 1e-24))


def with_history(values: Array, blocks: Blocks) -> Array:
    """Rows of the blocks with three predecessors: of one run a view, for copying them is most of the cost."""
    return values[3:] if blocks.with_history.size == values.shape[0] - 3 else values[blocks.with_history]


def _earlier(values: Array, blocks: Blocks, k: int) -> Array:
    """(m,) what they are k blocks before."""
    return values[3 - k : -k] if blocks.with_history.size == values.size - 3 else values[blocks.previous[k - 1]]


def _median(values: Array) -> float:
    return float(np.partition(values, values.size // 2)[values.size // 2])
