"""A process beside another: it stands back behind everything else on the machine, is bounded in what it takes, and ends
with the process that started it.

It loads nothing but Python's own, so that whatever else the process loads comes after it stood back.
"""

from __future__ import annotations

import os
import shutil
import threading
from contextlib import suppress
from importlib import import_module
from pathlib import Path

MAX_MEMORY_BYTES = 2 * 1024**3
"""Address space of the process: the longest trace known takes a quarter of it."""
MAX_FILE_BYTES = 64 * 1024**2
"""Largest file that it writes: an answer takes less than one."""
SESSION_NICENESS = "5"
"""The step by which its session stands back where Linux shares the processor among sessions first: the priority of a
process counts within its session alone there, and it has one of its own. It still gets a quarter of a core that another
session wants as a whole."""
FIRST_TO_END = "1000"
"""The score of the process that Linux ends first when memory runs out."""


def stand_back(niceness: int, processor_s: int) -> None:
    """Gives this process a lower priority, and bounds what it takes, as far as the machine knows how.

    Args:
        niceness: the step by which it stands back.
        processor_s: after so much processor time the process is ended [s].
    """
    with suppress(OSError, AttributeError):
        os.nice(niceness)
    for file, value in (("autogroup", SESSION_NICENESS), ("oom_score_adj", FIRST_TO_END)):
        with suppress(OSError):
            Path("/proc/self", file).write_text(value, encoding="ascii")
    try:
        resource = import_module("resource")
    except ModuleNotFoundError:  # Windows
        return
    for name, bound in (("AS", MAX_MEMORY_BYTES), ("CPU", processor_s), ("FSIZE", MAX_FILE_BYTES)):
        with suppress(OSError, ValueError):  # a lower bound is in force already
            resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (bound, bound))


def end_with_the_parent(folder: Path) -> None:
    """Ends this process, and removes the folder, once the one that started it is gone: it holds a pipe to this one's
    standard input, which the system closes with it."""

    def wait() -> None:
        # Not through sys.stdin: its lock, held here, would abort the interpreter at its end.
        while os.read(0, 1):
            pass
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
