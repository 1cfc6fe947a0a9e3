"""Compiled modules of SciPy by themselves.

What `import scipy.linalg` or `import scipy.signal` loads beside them takes a process 24 MB and half a second, and
nothing there is needed. So the compiled module alone is loaded, under SciPy's own name for it; where it does not stand
there, the whole package.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from importlib.machinery import PathFinder
from types import ModuleType


def compiled(name: str) -> ModuleType:
    """The compiled module of a package of SciPy, such as `scipy.linalg._flapack`."""
    return sys.modules.get(name) or _alone(name) or importlib.import_module(name)


def _alone(name: str) -> ModuleType | None:
    """The module without its package; None where this SciPy keeps it elsewhere."""
    scipy = importlib.util.find_spec("scipy")
    folder = name.split(".")[1]
    folders = [] if scipy is None else scipy.submodule_search_locations or []
    spec = PathFinder.find_spec(name, [f"{each}/{folder}" for each in folders])
    if spec is None or spec.loader is None:
        return None
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError:
        return None
    sys.modules[name] = module  # who loads all of SciPy finds this one
    return module
