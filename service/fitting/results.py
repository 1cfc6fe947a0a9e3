"""What results have in common: their tables, and the words that follow them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import how_to_install

SHOWS_STREAMS = "shows ranges, signs and units"
"""What `incsvr inspect` does after a result that no log explains."""


def frame(data: Mapping[str, Any] | Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> Any:
    """A DataFrame of columns by name, or of rows; `columns` names them where there may be no row.

    Raises:
        BadInput: pandas is not installed, and how it is.
    """
    try:
        pandas = import_module("pandas")
    except ModuleNotFoundError:
        raise BadInput(f"to_frame() needs pandas, which is not installed: {how_to_install('pandas')}") from None
    return pandas.DataFrame(data, columns=columns)
