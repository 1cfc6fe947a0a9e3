"""Packages that are loaded where they are needed alone, and the command that installs a missing one, by the extras in
the installed metadata."""

from __future__ import annotations

import re
from importlib import import_module
from importlib.metadata import PackageNotFoundError, metadata, requires
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput

_DISTRIBUTIONS = {
    "rerun": "rerun-sdk",
    "sklearn": "scikit-learn",
    "google": "protobuf",
    "yaml": "PyYAML",
}
"""Names of distributions by the name that is imported, where the two differ."""


def how_to_install(module: str) -> str:
    """The command that installs the package of `module`, for a checkout and for anywhere else.

    The package itself is in no registry: an extra of it can be named where its checkout is. What the extra holds can be
    installed anywhere.
    """
    package = _distribution(module)
    for extra, requirements in extras().items():
        if any(_name(requirement) == _normal(package) for requirement in requirements):
            listed = " ".join(f"'{requirement}'" for requirement in requirements)
            return f"pip install '.[{extra}]' in the checkout, or pip install {listed} anywhere"
    return f"pip install {package}"


def extras() -> dict[str, list[str]]:
    """The requirements of each extra, those that fewest need last."""
    found: dict[str, list[str]] = {}
    try:
        names, lines = metadata("incsvr").get_all("Provides-Extra") or [], requires("incsvr") or []
    except PackageNotFoundError:
        return found
    for line in lines:
        requirement, _, marker = line.partition(";")
        for name in names:
            if re.search(rf"""extra == ["']{re.escape(name)}["']""", marker):
                found.setdefault(name, []).append(requirement.strip())
    return {name: found[name] for name in sorted(found, key=lambda name: name in ("dev", "docs", "bench"))}


def _distribution(module: str) -> str:
    name = module.partition(".")[0]
    return _DISTRIBUTIONS.get(name, name)


def _name(requirement: str) -> str:
    return _normal(re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0])


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def load_package(module: str, path: Path | str, what: str) -> Any:
    """The module that reads `what` in `path`.

    Raises:
        BadInput: its package is not installed; the sentence names the command that installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = _distribution(module)
        raise BadInput(
            f"{path}: {what} is read by the package {package}, which does not load here ({error}); "
            f"install it: {how_to_install(package)}"
        ) from None


def plots() -> Any:
    """The module that draws figures; loaded when asked for, so that learning and tracing need no drawing library.

    Raises:
        BadInput: matplotlib is not installed; the sentence names the command that installs it.
    """
    return _drawing("viewer.plots", "plots")


def reports() -> Any:
    """The module that makes reports; otherwise as `plots`."""
    return _drawing("viewer.report", "reports")


def _drawing(module: str, what: str) -> Any:
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        package = missing.name or module
        raise BadInput(f"{what} need {package}, which is not installed: {how_to_install(package)}") from missing
