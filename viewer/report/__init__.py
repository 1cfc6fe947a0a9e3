"""The report of a trace: one self-contained HTML file that an engineer can read, print and file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW, Axis
from incsvr.tracing import Trace
from service.extras import how_to_install

__all__ = ["write"]


def write(found: Trace, path: Path, axis: Axis = YAW, made: Mapping[str, str] | None = None) -> None:
    """Writes the report of `found` to `path`, in the words and units of an axis.

    Args:
        made: what it was made of and how, by what to call it: recordings, command, software, date.

    Raises:
        BadInput: the drawing library is not installed, or the file cannot be written.
    """
    try:
        from viewer.report.page import page
    except ModuleNotFoundError as missing:
        raise BadInput(f"the report needs {missing.name}: {how_to_install(missing.name or '')}") from missing
    try:
        path.write_text(page(found, axis, made), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); name another file with --report") from error
