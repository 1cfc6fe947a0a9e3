"""How far a player is: a bar on a terminal, and lines where there is none, as in the log of a service."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from service.cli.display import Console

LINE_PERIOD_S = 30.0
"""Between two lines [s], wall time: a log that is read afterwards."""
ShowProgress = Callable[[int, float], None]
"""Called with how many messages were sent, and the vehicle's time since the first [s]."""


@contextmanager
def play_progress(command: str, name: str, count: int, seconds: float, speed: float) -> Iterator[ShowProgress]:
    """Shows on standard error how `count` messages are played, which take so long of the vehicle's time [s]."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines(f"incsvr {command}", name, count, seconds, speed)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[t]:.0f} of {task.fields[seconds]:.0f} s, left"),
        TimeRemainingColumn(compact=True),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(name, total=count, t=0.0, seconds=seconds)
        yield lambda sent, t: bar.update(task, completed=sent, t=min(t, seconds))


def _lines(head: str, name: str, count: int, seconds: float, speed: float) -> ShowProgress:
    began = time.monotonic()
    last = began

    def show(sent: int, t: float) -> None:
        nonlocal last
        now = time.monotonic()
        if sent == count:
            print(f"{head}: played {seconds:.0f} s, {count:,} messages, in {now - began:.0f} s", file=sys.stderr)
        elif now - last >= LINE_PERIOD_S:
            last = now
            print(f"{head}: {t:.0f} of {seconds:.0f} s of {name}", file=sys.stderr, flush=True)

    pace = f"{seconds:.0f} s at {speed:g} times the vehicle's pace, which takes {seconds / speed:.0f} s"
    print(f"{head}: plays {name}, {pace}", file=sys.stderr, flush=True)
    return show
