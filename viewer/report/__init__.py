"""The reports of a trace, a fit, a vehicle and of dives compared: one self-contained HTML file each, to keep."""

from __future__ import annotations

from pathlib import Path

from incsvr.errors import BadInput
from viewer.report.dives_page import dives_page
from viewer.report.fit_page import fit_page
from viewer.report.trace_page import trace_page
from viewer.report.vehicle_page import vehicle_page

__all__ = ["dives_page", "fit_page", "save", "trace_page", "vehicle_page"]


def save(page: str, path: Path) -> None:
    """Writes a page.

    Raises:
        BadInput: the file cannot be written.
    """
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); name another file with --report") from error
