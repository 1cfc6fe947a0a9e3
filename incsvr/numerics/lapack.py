"""LAPACK as SciPy brings it, without the rest of SciPy.

What `import scipy.linalg` loads beside it takes a learner 25 MB and half of its start, and nothing there is needed to
learn. So the compiled module alone is loaded, under SciPy's own name for it; where it does not stand there, the whole.
"""

from __future__ import annotations

import importlib.util
import sys
from importlib.machinery import PathFinder
from types import ModuleType

import numpy as np

from incsvr.numerics.arrays import Array

MODULE = "scipy.linalg._flapack"


def _alone() -> ModuleType | None:
    """The compiled module by itself; None where this SciPy keeps it elsewhere."""
    package = importlib.util.find_spec("scipy")
    folders = [] if package is None else package.submodule_search_locations or []
    spec = PathFinder.find_spec(MODULE, [f"{folder}/linalg" for folder in folders])
    if spec is None or spec.loader is None:
        return None
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError:
        return None
    sys.modules[MODULE] = module  # who loads all of SciPy finds this one
    return module


def _loaded() -> ModuleType:
    module = sys.modules.get(MODULE) or _alone()
    if module is not None:
        return module
    from scipy.linalg import lapack

    return lapack


_lapack = _loaded()
dposv, dpotrf, dpotrs, dpstrf = _lapack.dposv, _lapack.dpotrf, _lapack.dpotrs, _lapack.dpstrf
"""Solution of a positive definite system; its Cholesky factor, and a solution by it; the factor with pivots."""
dtbtrs = _lapack.dtbtrs
"""Solution of a triangular system with a band."""


def cholesky(matrix: Array) -> Array:
    """The upper Cholesky factor of an (n, n) matrix, as `dpotrs` takes it: what stands below it means nothing.

    Raises:
        LinAlgError: the matrix is not positive definite.
    """
    factor, failed = dpotrf(matrix, clean=0)
    if failed:
        raise np.linalg.LinAlgError(f"the leading minor of order {failed} is not positive definite")
    return np.asarray(factor)
