"""The blocks of a page that are run: ```console and ```python. They run in their order, in one empty directory.

Lines `$ …` of a console are commands, with what they print below them; `| head -n 3`, `| tail -n 3` and
`| sed -n 3,5p` show a part of it. The Python blocks of a page are one notebook: a name lives on in the blocks below.
What a block prints is in a block ```text below it. The logs of docs/logs are there, and the scripts that make some.

A learner whose command ends in `&` runs beside the others until the page ends. The bus is on a free port; the pages
tell the usual one.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from threading import Event

from service.bus.session import client_config_at, free_endpoint, open_session
from service.config.configuration import Config
from service.config.sections import Bus
from service.wire import Keys
from simulator.player import wait_for_learner
from tests.conftest import ROOT

PAGES = (
    "README.md",
    "docs/tutorial-log.md",
    "docs/tutorial-vehicle.md",
    "docs/tutorial-notebook.md",
    "docs/tutorial-simulator.md",
    "docs/python.md",
    "docs/whole_vehicle.md",
    "docs/dives.md",
)
END = "the block has ended"
NOTEBOOK = f"""
import json, sys

names = {{"__name__": "__main__"}}
for line in sys.stdin:
    exec(compile(json.loads(line), "a block of the page", "exec"), names)
    print("{END}", flush=True)
"""
BLOCK = re.compile(r"^```(console|python)\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
PATIENCE = 30.0
"""How long a learner may take to start [s]."""
WALL = re.compile(r", in \d+(?:\.\d+)? s$")
"""How long something took here, at the end of a line."""
WAITING = re.compile(r"incsvr: .*, \d+ s")
"""A line of progress, which a command prints every 30 s: only on a busy machine does one of the pages take as long."""
CLOSE = 0.03
"""Part by which a printed figure may differ on another machine, whose BLAS rounds otherwise."""


def printed(page: Path, folder: Path) -> str:
    """The page's text with what its blocks print now, run in `folder`."""
    text = page.read_text(encoding="utf-8")
    parts, end = [], 0
    shutil.copytree(ROOT / "docs/logs", folder / "docs/logs")
    with ExitStack() as beside:
        shell = Shell(folder, free_endpoint(), beside)
        for block in BLOCK.finditer(text):
            kind, body, _ = block.groups()
            parts.append(text[end : block.start()])
            if kind == "console":
                ran = "".join(f"$ {command}\n{shell.run(command)}" for command in commands(body))
                parts.append(f"```console\n{ran}```\n")
            else:
                output = shell.cell(body)
                parts.append(f"```python\n{body}```\n" + (f"\n```text\n{output}```\n" if output else ""))
            end = block.end()
    return "".join([*parts, text[end:]])


def commands(body: str) -> Iterator[str]:
    """The commands of a console block."""
    return (line.removeprefix("$ ") for line in body.splitlines() if line.startswith("$ "))


@dataclass(frozen=True)
class Shell:
    """Where commands run: their directory, their bus, and what ends those that run beside the others."""

    folder: Path
    endpoint: str
    beside: ExitStack

    @cached_property
    def _notebook(self) -> subprocess.Popen[str]:
        """The Python in which the blocks of the page run, one after the other, until the page ends."""
        process = subprocess.Popen(
            [sys.executable, "-c", NOTEBOOK],
            cwd=self.folder,
            env=self._settings,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        return self.beside.enter_context(process)  # which ends with its standard input

    def cell(self, block: str) -> str:
        """What a block of Python prints, on either output."""
        asked, answered = self._notebook.stdin, self._notebook.stdout
        assert asked is not None
        assert answered is not None
        print(json.dumps(block), file=asked, flush=True)
        lines: list[str] = []
        for line in answered:
            if line == f"{END}\n":
                return _without_waiting("".join(lines))
            lines.append(line)
        raise AssertionError(f"{block}\n{''.join(lines)}")

    def run(self, command: str) -> str:
        """What a command prints; nothing where it is a learner that runs beside the others, once it can be asked."""
        command, _, part = command.partition(" | ")
        words = self._words(command.removesuffix("&"))
        if part:  # `head -n 3`, `tail -n 3` or `sed -n 3,5p`
            end, _, count = shlex.split(part)
            lines = self.printed_by(words).splitlines(keepends=True)
            if end == "sed":
                first, _, last = count.removesuffix("p").partition(",")
                return "".join(lines[int(first) - 1 : int(last)])
            return "".join(lines[: int(count)] if end == "head" else lines[-int(count) :])
        if not command.endswith("&"):
            return self.printed_by(words)
        silent = subprocess.DEVNULL
        process = subprocess.Popen(words, cwd=self.folder, env=self._settings, stdout=silent, stderr=silent)
        self.beside.callback(process.wait)
        self.beside.callback(process.terminate)
        with open_session(client_config_at(self.endpoint), PATIENCE) as session:
            wait_for_learner(session, Keys(Config().prefix), PATIENCE, Event())
        return ""

    def printed_by(self, words: list[str]) -> str:
        """What a command prints, on either output."""
        ran = subprocess.run(
            words,
            cwd=self.folder,
            env=self._settings,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        assert ran.returncode == 0, f"{shlex.join(words)}: {ran.stdout}"
        return _without_waiting(ran.stdout.replace(self.endpoint, Bus().listen))

    def _words(self, command: str) -> list[str]:
        """A command as it is run here, by our own programs."""
        program, *rest = shlex.split(command)
        ours = program == "incsvr" or rest[0].startswith("docs/logs/")
        assert ours, f"{command}: only incsvr and the scripts of docs/logs are run"
        return [str(Path(sys.executable).parent / program), *rest]

    @property
    def _settings(self) -> dict[str, str]:
        return {
            **os.environ,
            "INCSVR_BUS__LISTEN": self.endpoint,
            "MPLBACKEND": "Agg",
            "NO_COLOR": "1",
            "COLUMNS": "120",
            "OPENBLAS_NUM_THREADS": "1",
        }


def _without_waiting(text: str) -> str:
    """What was printed, without lines of progress and spaces at the ends of lines."""
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines() if not WAITING.fullmatch(line))


def differs(told: str, now: str) -> str | None:
    """The first lines of two texts that say different things; None where figures differ by rounding alone."""
    before, after = ([WALL.sub("", line) for line in text.splitlines()] for text in (told, now))
    for one, other in zip(before, after, strict=False):
        if NUMBER.sub("#", one).split() != NUMBER.sub("#", other).split():
            return f"the page says\n  {one}\nthe program says\n  {other}"
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True):
            if abs(float(a) - float(b)) > CLOSE * max(abs(float(a)), abs(float(b))):
                return f"the page says {a}, the program {b}, in\n  {other}"
    return None if len(before) == len(after) else f"{len(before)} lines on the page, {len(after)} printed"
