"""The blocks of a page that are run: ```console, whose lines `$ …` are commands with what they print below them, and
```python, with what it prints in a block ```text below it. They run in their order, in one empty directory."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.conftest import ROOT

PAGES = ("docs/tutorial-log.md", "docs/tutorial-vehicle.md", "docs/python.md")
BLOCK = re.compile(r"^```(console|python)\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
CLOSE = 0.03
"""Part by which a printed figure may differ on another machine, whose BLAS rounds otherwise."""


def printed(page: Path, folder: Path) -> str:
    """The page's text with what its blocks print now, run in `folder`."""
    text = page.read_text(encoding="utf-8")
    parts, end = [], 0
    for block in BLOCK.finditer(text):
        kind, body, _ = block.groups()
        parts.append(text[end : block.start()])
        if kind == "console":
            ran = "".join(f"$ {command}\n{_run(_words(command, folder), folder)}" for command in commands(body))
            parts.append(f"```console\n{ran}```\n")
        else:
            output = _run([sys.executable, "-c", body], folder)
            parts.append(f"```python\n{body}```\n" + (f"\n```text\n{output}```\n" if output else ""))
        end = block.end()
    return "".join([*parts, text[end:]])


def commands(body: str) -> Iterator[str]:
    """The commands of a console block."""
    return (line.removeprefix("$ ") for line in body.splitlines() if line.startswith("$ "))


def _words(command: str, folder: Path) -> list[str]:
    """A command as it is run here: our own program, our own Python, and scripts that stand beside the page."""
    program, *rest = shlex.split(command)
    if program == "python":
        shutil.copy(ROOT / "docs" / rest[0], folder)
        return [sys.executable, *rest]
    assert program == "incsvr", f"{command}: only incsvr and python are run"
    return [str(Path(sys.executable).parent / "incsvr"), *rest]


def _run(words: list[str], folder: Path) -> str:
    """What a command prints, on either output."""
    settings = {**os.environ, "MPLBACKEND": "Agg", "NO_COLOR": "1", "COLUMNS": "120", "OPENBLAS_NUM_THREADS": "1"}
    ran = subprocess.run(
        words, cwd=folder, env=settings, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    assert ran.returncode == 0, f"{shlex.join(words)}: {ran.stdout}"
    return "\n".join(line.rstrip() for line in ran.stdout.splitlines()) + "\n" * bool(ran.stdout)


def differs(told: str, now: str) -> str | None:
    """The first lines of two texts that say different things; None where figures differ by rounding alone."""
    before, after = told.splitlines(), now.splitlines()
    for one, other in zip(before, after, strict=False):
        if NUMBER.sub("#", one).split() != NUMBER.sub("#", other).split():
            return f"the page says\n  {one}\nthe program says\n  {other}"
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True):
            if abs(float(a) - float(b)) > CLOSE * max(abs(float(a)), abs(float(b))):
                return f"the page says {a}, the program {b}, in\n  {other}"
    return None if len(before) == len(after) else f"{len(before)} lines on the page, {len(after)} printed"
