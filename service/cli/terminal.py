"""The terminal: what others wrote (names of columns, vehicles and keys, messages) is shown there and never obeyed."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from typing import Any, TextIO, cast

_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")
"""Characters that move the cursor, colour, clear, ring or turn the direction of text; not the tab and the new line."""


def shown(text: str) -> str:
    """The text with each control character spelt as JSON spells it, such as \\u001b."""
    return _CONTROL.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


class _Shown:
    """A stream that spells control characters; `raw` is the one behind it."""

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw

    def write(self, text: str) -> int:
        return self.raw.write(shown(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


def behind(stream: TextIO) -> TextIO:
    """The stream behind one of `spelt_controls`, for what draws in colours itself."""
    return stream.raw if isinstance(stream, _Shown) else stream


@contextmanager
def spelt_controls() -> Iterator[None]:
    """A context in which whatever is printed spells control characters."""
    with ExitStack() as streams:
        streams.enter_context(redirect_stdout(cast(TextIO, _Shown(sys.stdout))))
        streams.enter_context(redirect_stderr(cast(TextIO, _Shown(sys.stderr))))
        yield
