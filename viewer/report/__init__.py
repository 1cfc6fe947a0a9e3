"""The reports of a trace, a fit, a vehicle and of dives compared: one self-contained HTML file each, to keep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.forecasting.over_recordings import FitPictures
from incsvr.plant.axes import YAW, Axis
from incsvr.tracing.findings import Trace
from incsvr.vehicle import Comparison, Identified
from service.cli.extras import how_to_install

__all__ = ["write", "write_dives", "write_fit", "write_vehicle"]


def write(trace: Trace, path: Path, axis: Axis = YAW, provenance: Mapping[str, str] | None = None) -> None:
    """Writes the report of a trace to `path`, in the words and units of an axis.

    Args:
        provenance: what it was made of and how, by what to call it: recordings, command, software, date.

    Raises:
        BadInput: the drawing library is not installed, or the file cannot be written.
    """
    with _needs_libraries():
        from viewer.report.page import page
    _write(path, page(trace, axis, provenance))


def write_fit(
    result: Mapping[str, Any],
    pictures: FitPictures,
    path: Path,
    axis: Axis = YAW,
    provenance: Mapping[str, str] | None = None,
) -> None:
    """Writes the report of a fit: `result` is what `incsvr fit --json` writes; otherwise as `write`."""
    with _needs_libraries():
        from viewer.report.fit_page import fit_page
    _write(path, fit_page(result, pictures, axis, provenance))


def write_vehicle(
    found: Identified, path: Path, notes: Sequence[str] = (), provenance: Mapping[str, str] | None = None
) -> None:
    """Writes the report of a whole vehicle; `notes` are those of the readers of its logs; otherwise as `write`."""
    with _needs_libraries():
        from viewer.report.vehicle_page import vehicle_page
    _write(path, vehicle_page(found, notes, provenance))


def write_dives(
    compared: Comparison,
    explanations: Mapping[str, Sequence[str]],
    path: Path,
    provenance: Mapping[str, str] | None = None,
) -> None:
    """Writes the report of dives compared; `explanations` are the causes that fit by dive; otherwise as `write`."""
    with _needs_libraries():
        from viewer.report.dives_page import dives_page
    _write(path, dives_page(compared, explanations, provenance))


@contextmanager
def _needs_libraries() -> Iterator[None]:
    """Says which package is missing, and how it is installed."""
    try:
        yield
    except ModuleNotFoundError as missing:
        raise BadInput(f"the report needs {missing.name}: {how_to_install(missing.name or '')}") from missing


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); name another file with --report") from error
