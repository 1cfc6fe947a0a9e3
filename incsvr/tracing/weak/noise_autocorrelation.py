"""The colour of the noise: an AR(3) by Burg's method.

Source: J. P. Burg, "Maximum entropy spectral analysis" (1975).
"""

from __future__ import annotations

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.weak.weak_form import Blocks

DEGREES = 6.0
"""ν of the innovations: outliers of a few per cent cost nothing, Gaussian noise costs 4 % of the efficiency."""


def burg(residual: Array, blocks: Blocks, order: int = 3) -> Array:
    """AR coefficients of `residual`, pooled over the runs; outliers are drawn in to four deviations first."""
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


def scale_of(weight: Array, innovation: Array) -> float:
    """s of weighted innovations."""
    return float(np.sqrt(float((weight * innovation) @ innovation) / innovation.size + 1e-24))


def with_history(values: Array, blocks: Blocks) -> Array:
    """Rows of the blocks with three predecessors: of one run a view, for copying them is most of the cost."""
    return values[3:] if blocks.with_history.size == values.shape[0] - 3 else values[blocks.with_history]


def _median(values: Array) -> float:
    return float(np.partition(values, values.size // 2)[values.size // 2])
