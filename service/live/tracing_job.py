"""The program of the process beside the learner: it traces, or compares free runs.

`python -m service.live.tracing_job FOLDER`.

The folder holds `job.json` and `streams.npz`; the answer is written there as `answer.json`. Exit status 0 done, 1 the
data cannot answer (one sentence on standard error). The process stands back behind everything else on the machine and
is bounded in memory; it loads nothing but Python's own before. When the learner ends, so does this process, with its
folder.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import threading
from contextlib import suppress
from importlib import import_module
from pathlib import Path

from incsvr.errors import BadInput

NICENESS = 10
"""The step by which it stands back: it still gets a tenth of a core that others want as a whole."""
MAX_MEMORY_BYTES = 2 * 1024**3
"""Address space of the process: the longest trace known takes a quarter of it."""
SESSION_NICENESS = "5"
"""The step by which its session stands back where Linux shares the processor among sessions first: the priority of a
process counts within its session alone there, and it has one of its own. It still gets a quarter of a core that another
session wants as a whole."""
FIRST_TO_END = "1000"
"""The score of the process that Linux ends first when memory runs out."""


def main(folder: Path) -> int:
    stand_back()
    end_with_the_parent(folder)
    try:
        _answer(folder)
    except BadInput as error:
        print(error, file=sys.stderr)
        return 1
    except MemoryError:
        print(f"it needs more than {MAX_MEMORY_BYTES / 1e9:.1f} GB of memory", file=sys.stderr)
        return 1
    return 0


def stand_back() -> None:
    """Gives this process a lower priority and bounds its memory, as far as the machine knows how."""
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)
    for file, value in (("autogroup", SESSION_NICENESS), ("oom_score_adj", FIRST_TO_END)):
        with suppress(OSError):
            Path("/proc/self", file).write_text(value, encoding="ascii")
    # No such module on Windows; a lower bound may be in force already.
    with suppress(ModuleNotFoundError, OSError, ValueError):
        resource = import_module("resource")
        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))


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


def _answer(folder: Path) -> None:
    # Loaded at the lowest priority and within the bounds.
    import numpy as np

    from service.live.tracing_answer import answer
    from service.wire.json_text import write_json

    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    with np.load(folder / "streams.npz") as kept:
        names = [name.removesuffix("/t") for name in kept.files if name.endswith("/t")]
        streams = {name: (kept[f"{name}/t"], kept[f"{name}/v"]) for name in names}
    write_json(folder / "answer.json", answer(job, streams))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
