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
"""Address space of the process: the longest trace known and five minutes of six axes take a quarter of it."""
MAX_FILE_BYTES = 64 * 1024**2
"""Largest file that it writes: a report takes less than one."""
NO_ANSWER = 2
"""Exit status of a process whose data cannot answer."""
NICENESS = 10
"""The step by which the process stands back: it still gets a tenth of a core that others want as a whole."""
FIRST_TO_END = "1000"
"""The score of the process that Linux ends first when memory runs out."""


def stand_back(processor_s: int) -> None:
    """Gives this process a low priority, and bounds what it takes, as far as the machine knows how.

    Args:
        processor_s: after so much processor time the process is ended [s].
    """
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(FIRST_TO_END, encoding="ascii")
    try:
        resource = import_module("resource")
    except ModuleNotFoundError:  # Windows
        return
    for name, bound in (("AS", MAX_MEMORY_BYTES), ("CPU", processor_s), ("FSIZE", MAX_FILE_BYTES)):
        with suppress(OSError, ValueError):  # a lower bound is in force already
            resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (bound, bound))


def end_with_the_parent(folder: Path | None = None) -> None:
    """Ends this process, and removes the folder, once the one that started it is gone: it holds a pipe to this one's
    standard input, which the system closes with it."""

    def wait() -> None:
        # Not through sys.stdin: its lock, held here, would abort the interpreter at its end.
        while os.read(0, 1):
            pass
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
