"""The command that installs a missing package, by the extras in the installed metadata."""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, metadata, requires

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
    package = _DISTRIBUTIONS.get(module.partition(".")[0], module.partition(".")[0])
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


def _name(requirement: str) -> str:
    return _normal(re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0])


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
