"""LAPACK as SciPy brings it, without the rest of SciPy (compiled.py).

What `import scipy.linalg` loads beside it takes a learner 25 MB and half of its start.
"""

from __future__ import annotations

import numpy as np

from incsvr.numerics.arrays import Array
from incsvr.numerics.compiled import compiled

MODULE = "scipy.linalg._flapack"

_lapack = compiled(MODULE)
dposv, dpotrf, dpotrs, dpstrf = _lapack.dposv, _lapack.dpotrf, _lapack.dpotrs, _lapack.dpstrf
"""Solution of a positive definite system; its Cholesky factor, and a solution by it; the factor with pivots."""
dtrtrs, dtbtrs = _lapack.dtrtrs, _lapack.dtbtrs
"""Solution of a triangular system; of one with a band."""


def cholesky(matrix: Array) -> Array:
    """The upper Cholesky factor of an (n, n) matrix, as `dpotrs` takes it: what stands below it means nothing.

    Raises:
        LinAlgError: the matrix is not positive definite.
    """
    factor, failed = dpotrf(matrix, clean=0)
    if failed:
        raise np.linalg.LinAlgError(f"the leading minor of order {failed} is not positive definite")
    return np.asarray(factor)


def banded(band: Array, right: Array) -> Array:
    """(n,) x of A x = b, for a positive definite A whose diagonal and those below it are the rows of `band`."""
    return np.asarray(_lapack.dpbsv(band, right[:, None], lower=1)[1][:, 0])
