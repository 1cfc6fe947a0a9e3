"""A progress bar on standard error: only on a terminal, only for what takes longer than a second, gone when done.

Nothing is shown to programs, which ask with `--json`: the command line calls them within `without_bars`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Timer

BAR_AFTER_S = 1.0
"""Shorter work shows no bar [s]."""
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
def progress(what: str, total: int | None = None) -> Iterator[Callable[[], None]]:
    """Yields what is to be called after each of `total` steps; None where nobody knows how many there are."""
    if _hidden.get() or not sys.stderr.isatty():
        yield lambda: None
        return
    # Loaded where it is needed alone: a learner has no terminal.
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from service.cli.console import Console

    count = () if total is None else (MofNCompleteColumn(),)
    columns = (TextColumn("{task.description}"), BarColumn(), *count, TimeElapsedColumn())
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task(what, total=total)
    # A step may be long: the bar appears in the middle of it.
    late = Timer(BAR_AFTER_S, bar.start)
    late.daemon = True
    late.start()
    try:
        yield lambda: bar.advance(task)
    finally:
        late.cancel()
        late.join()
        bar.stop()
