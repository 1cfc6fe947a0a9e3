"""The output of a command: a text for people, or one JSON object for programs (CONTRACT, Section 3)."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from textwrap import wrap
from typing import Any

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service.cli.terminal import behind
from service.wire import IterationReport, Learning
from service.wire.json_text import json_text, write_json

WIDTH = 80
"""Columns of a line for people."""
HEAD_CHARACTERS = 1000
"""Characters at the begin of a file among which the mark of what `incsvr` wrote stands."""


def destination(text: str) -> Path:
    """A file that is to be written, as a type of argparse: what cannot be written is said before any work is done."""
    path = Path(text)
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{path} is a folder; name a file in it")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {path.parent}; make it, or name a file elsewhere")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"{path} cannot be written; name a file elsewhere")
    return path


def report_destination(text: str) -> Path:
    """The file of a report, which is one page of HTML, as a type of argparse."""
    path = destination(text)
    if path.suffix.lower() not in (".html", ".htm"):
        page = path.with_suffix(".html").name
        raise argparse.ArgumentTypeError(f"the report is a page of HTML: name it {page} (a browser prints it as PDF)")
    return path


def refuse_unwritable(path: Path, flag: str = "") -> None:
    """Refuses a file that cannot be written, before the work is done that it is to hold; `flag` names another one.

    Raises:
        BadInput: it is a folder, or stands in none.
    """
    if path.is_dir() or not path.parent.is_dir():
        raise BadInput(f"{path} cannot be written; name a file in a folder that is there{_with(flag)}")


def refuse_replacing(path: Path, mark: str, flag: str) -> None:
    """Refuses a file that cannot be written, and a file without the mark of what it is to hold: a person wrote it.

    Raises:
        BadInput: as `refuse_unwritable`, or the file holds something else.
    """
    refuse_unwritable(path, flag)
    if not path.is_file():
        return
    with path.open(encoding="utf-8", errors="replace") as file:
        head = file.read(HEAD_CHARACTERS)
    if head and mark not in head:
        raise BadInput(f"{path} is not replaced, because incsvr did not write it; name another file{_with(flag)}")


@contextmanager
def writing(path: Path, flag: str = "") -> Iterator[None]:
    """A context in which a file is written; errors name `flag`, which selects another file.

    Raises:
        BadInput: the file cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); name another file{_with(flag)}") from error


def _with(flag: str) -> str:
    return f" with {flag}" if flag else ""


def wrapped(begin: str, sentences: Iterable[str]) -> list[str]:
    """Lines of at most WIDTH columns: each sentence behind `begin`, and what does not fit below it."""
    return [
        line
        for sentence in sentences
        for line in wrap(sentence, WIDTH, initial_indent=begin, subsequent_indent="    ", break_on_hyphens=False)
    ]


def shortened(text: str, columns: int) -> str:
    """The end of a text that takes more columns than there are, behind an ellipsis."""
    return text if len(text) <= columns else f"…{text[1 - columns :]}"


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `--json`: `-` for standard output, else a file."""
    parser.add_argument(
        "--json",
        metavar="FILE",
        type=lambda text: text if text == "-" else str(destination(text)),
        help="write the result as one JSON object; - for standard output",
    )


def emit(args: argparse.Namespace, result: Mapping[str, Any], text: str, *, drawn: bool = False) -> None:
    """Prints `text` for people and, where `--json` was given, writes `result` for programs.

    A file is written first: nobody who stops reading the text loses it. With `--json -` standard output carries the
    JSON object alone, and the text goes to standard error. A text that a console has `drawn` keeps its colours.
    """
    target: str | None = args.json
    if target not in (None, "-"):
        write_json(Path(target), result, indent=2)
    stream = sys.stderr if target == "-" else sys.stdout
    print(text, file=behind(stream) if drawn else stream)
    if target == "-":
        print(json_text(result, indent=2))


def iteration_line(report: IterationReport, axis: Axis = YAW) -> str:
    """The line of an iteration, in 80 columns, with a second line if the learner noticed a change of the vehicle.

    The error is that of the model before on the batch, before it was learned.
    """
    counts = report.counts
    did = "nothing new"
    if report.trained:
        did = f"{counts['new']} new, {counts['forgotten']} forgotten, {counts['outliers']} out"
    unit = words_of(axis).effort_unit
    error = "" if report.progressive_mae is None else f", error {report.progressive_mae:.3g} {unit}"
    line = f"iteration {report.iteration}, {report.t:.0f} s: {did}, {counts['support']} vectors{error}"
    return line if report.change is None else f"{line}\n  {report.change}"


def learning_line(learning: Learning) -> str:
    """The line that reports the state of learning, with the reason if it has stopped."""
    if learning.state == "learning":
        return f"learning continues at {learning.since:.1f} s"
    return f"learning is {learning.state} since {learning.since:.1f} s: {learning.why}"
