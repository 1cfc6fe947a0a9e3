"""The common tools of all rooms: the type of an array, sizes of errors, integrals and means of streams."""

from __future__ import annotations

from incsvr.numerics.arrays import Array, Stream, Streams
from incsvr.numerics.cell_means import cell_means, integral_at, running_integral
from incsvr.numerics.correlation import MAX_CORRELATION, independent_part, independent_share
from incsvr.numerics.deviation import robust_deviation, root_mean_square

__all__ = [
    "MAX_CORRELATION",
    "Array",
    "Stream",
    "Streams",
    "cell_means",
    "independent_part",
    "independent_share",
    "integral_at",
    "robust_deviation",
    "root_mean_square",
    "running_integral",
]
