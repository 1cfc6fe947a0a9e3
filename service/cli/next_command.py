"""The one command that follows a result, and its line for people."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

LOG_FLAGS = ("config", "preset", "system", "column", "cut_from", "cut_to")
"""The flags that say what is in a log."""
AXIS_FLAGS = (*LOG_FLAGS, "axis", "vehicle", "inertia", "set", "assume_sign")
"""The flags of `fit` and `trace` that both have in common."""
WRITTEN = "learned.yaml"
"""The configuration that the next command writes."""
COMMON_VALUES = ("vehicle.", "inputs.", "signals.torque=")
"""Begins of the values of `--set` that `fit` and `trace` both take."""


def following(said: Any, command: str, files: Sequence[Path | str], flags: Iterable[str], *more: str) -> str:
    """A command over the same files, with those of the `flags` that are `said` as attributes, and with `more` words."""
    words = ["incsvr", command, *map(str, files)]
    for name in flags:
        value = getattr(said, name, None)
        flag = f"--{name.removeprefix('cut_').replace('_', '-')}"
        if value is True:
            words.append(flag)
            continue
        for each in value if isinstance(value, list | tuple) else [value] * (value is not None and value is not False):
            text = str(getattr(each, "text", each)).removesuffix(".0" if name == "inertia" else "")  # as Python gave it
            if name != "set" or text.startswith(COMMON_VALUES):
                words += [flag, text] if not text.startswith("-") else [f"{flag}={text}"]
    unseen = [str(path) for path in getattr(said, "validate", None) or []] if command != "inspect" else []
    return shlex.join([*words, *(["--validate", *unseen] if unseen else []), *more])


def next_line(command: str, why: str) -> str:
    """The line of a result that names the command which follows, and what it does."""
    return f"What next?  {command}\n            {why}"


def with_next(text: str, command: str | None, why: str) -> str:
    """A text, and below it the line of the command that follows, if one does."""
    return text if command is None else f"{text}\n\n{next_line(command, why)}"
