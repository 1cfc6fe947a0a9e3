"""The packages that read the field's formats: loaded where they are needed alone, and named where they are missing."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import how_to_install

DISTRIBUTIONS = {
    "pyarrow": "pyarrow",
    "mcap": "mcap",
    "rosbags": "rosbags",
    "pymavlink": "pymavlink",
    "pyulog": "pyulog",
    "google": "protobuf",
}
"""The distribution to install, by the name that is imported."""


def load_package(module: str, path: Path | str, what: str) -> Any:
    """The module that reads `what` in `path`.

    Raises:
        BadInput: its package is not installed; the sentence names the command that installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = DISTRIBUTIONS[module.partition(".")[0]]
        raise BadInput(
            f"{path}: {what} is read by the package {package}, which does not load here ({error}); "
            f"install it: {how_to_install(package)}"
        ) from None
