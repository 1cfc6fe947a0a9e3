"""What the results of all functions have in common: their text, their pictures and their tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import how_to_install


class Result:
    """The result of a function; `str` and `repr` are the text that its command prints."""

    __slots__ = ()

    @property
    def text(self) -> str:
        """The result for people, with the command that follows."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return self.text


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


def with_next(text: str, following: str) -> str:
    """A text with the line of the command that follows, if one does."""
    return f"{text}\n\n{following}" if following else text
