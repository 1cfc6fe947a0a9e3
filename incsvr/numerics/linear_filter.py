"""A linear filter as SciPy brings it, `scipy.signal.lfilter`, without the rest of SciPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics.arrays import Array
from incsvr.numerics.compiled import compiled

_filter = compiled("scipy.signal._sigtools")._linear_filter


def lfilter(b: Sequence[float], a: Sequence[float], x: Array) -> Array:
    """(n,) the filter b/a of (n,) values, from rest; a has at least two coefficients."""
    return np.asarray(_filter(np.asarray(b, float), np.asarray(a, float), x, -1))
