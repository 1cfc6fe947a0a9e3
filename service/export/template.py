"""The templates of formats, one file each."""

from __future__ import annotations

from importlib.resources import files
from string import Template


def filled(template: str, /, **values: object) -> str:
    """The text of a format; a list of lines takes the place of a line, and an empty one takes it away."""
    lines = list[str]()
    for line in (files("service.export") / f"{template}.template").read_text(encoding="utf-8").splitlines():
        value = values.get(line.strip().removeprefix("$"))
        lines += map(str, value) if isinstance(value, list) else [Template(line).substitute(values)]
    return "\n".join(lines) + "\n"
