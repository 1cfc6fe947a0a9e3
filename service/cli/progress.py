"""Progress on standard error: on a terminal a bar for what takes longer than a second, gone when done; else lines.

Nothing is shown to programs, which ask with `--json`: the command line calls them within `without_bars`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event, Thread, Timer

BAR_AFTER_S = 1.0
"""Shorter work shows no bar [s]."""
LINE_PERIOD_S = 30.0
"""Between two lines where there is no terminal [s]; shorter work shows none."""
Advance = Callable[..., None]
"""Called after each step, or as each begins with what it does."""
_hidden = ContextVar("hidden", default=False)


@contextmanager
def without_bars(hides: bool = True) -> Iterator[None]:
    """A context in which no bar is shown."""
    before = _hidden.set(hides)
    try:
        yield
    finally:
        _hidden.reset(before)


@contextmanager
def progress(what: str, total: int | None = None) -> Iterator[Advance]:
    """Yields what is to be called for each of `total` steps; None where nobody knows how many there are."""
    if _hidden.get():
        yield lambda step="": None
        return
    with (_bar if sys.stderr.isatty() else _lines)(what, total) as advance:
        yield advance


@contextmanager
def _bar(what: str, total: int | None) -> Iterator[Advance]:
    # Loaded where it is needed alone: a learner has no terminal.
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from service.cli.display import Console

    count = () if total is None else (MofNCompleteColumn(),)
    columns = (TextColumn("{task.description}"), BarColumn(), *count, TimeElapsedColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=total)
    # A step may be long: the bar appears in the middle of it.
    late = Timer(BAR_AFTER_S, bar.start)
    late.daemon = True
    late.start()
    try:
        yield lambda step="": bar.update(task, advance=1, description=f"{what}: {step}" if step else what)
    finally:
        late.cancel()
        late.join()
        bar.stop()


@contextmanager
def _lines(what: str, total: int | None) -> Iterator[Advance]:
    began, over, done, now = time.monotonic(), Event(), 0, ""

    def advance(step: str = "") -> None:
        nonlocal done, now
        done, now = done + 1, f": {step}" if step else ""

    def write() -> None:
        while not over.wait(LINE_PERIOD_S):
            count = "" if total is None else f", {done} of {total}"
            print(f"incsvr: {what}{count}{now}, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)

    writer = Thread(target=write, daemon=True)
    writer.start()
    try:
        yield advance
    finally:
        over.set()
        writer.join()
