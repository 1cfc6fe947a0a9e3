"""`python -m tests.docs.messages` lists every text of the programs that a person reads, by file and line.

A text is a string of at least three words in the code that is installed and is no docstring: messages, help, reasons of
health, notes, reports, pages. The expressions of f-strings are shown in braces.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass

from tests.conftest import ROOT

PACKAGES = ("incsvr", "service", "simulator", "viewer")
MIN_WORDS = 3
WORD = re.compile(r"[A-Za-z][a-z']+")


@dataclass(frozen=True)
class Text:
    """A text that a person reads, and its place in the code."""

    path: str
    line: int
    words: str


def texts() -> Iterator[Text]:
    """The texts of all packages, in the order of files and lines."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            yield from _texts(tree, path.relative_to(ROOT).as_posix())


def _texts(tree: ast.Module, path: str) -> Iterator[Text]:
    other = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            other |= {id(part) for part in ast.walk(node) if part is not node}
    for node in ast.walk(tree):
        if id(node) in other or not isinstance(node, ast.JoinedStr | ast.Constant):
            continue
        words = _words(node)
        if " " in words.strip() and len(WORD.findall(re.sub(r"{[^}]*}", "", words))) >= MIN_WORDS:
            yield Text(path, node.lineno, words)


def _words(node: ast.JoinedStr | ast.Constant) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    return "".join(
        str(part.value) if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)}}}"
        for part in node.values
        if isinstance(part, ast.Constant | ast.FormattedValue)
    )


def main() -> None:
    for text in texts():
        print(f"{text.path}:{text.line}: {text.words}")


if __name__ == "__main__":
    main()
