"""XML elements to be put into a tool's file, below a comment."""

from __future__ import annotations

from collections.abc import Sequence


def fragment(remarks: Sequence[str], elements: Sequence[str]) -> str:
    """The text of the elements; two hyphens may not stand in a comment, so that others take their place."""
    lines = [line.replace("--", "\u2010\u2010") for line in remarks]
    return "\n".join(["<!-- By incsvr export.", *(f"     {line}" for line in lines), "-->", *elements]) + "\n"
