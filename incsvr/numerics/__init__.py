"""The common tools of all rooms: the type of an array, sizes of errors, integrals and means of streams."""

from __future__ import annotations

from incsvr.numerics.arrays import Array, Stream, Streams
from incsvr.numerics.cell_means import cell_means, integral_at, running_integral
from incsvr.numerics.deviation import robust_deviation, root_mean_square

__all__ = [
    "Array",
    "Stream",
    "Streams",
    "cell_means",
    "integral_at",
    "robust_deviation",
    "root_mean_square",
    "running_integral",
]
