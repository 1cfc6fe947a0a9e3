"""The program of the process beside the learner: it traces, or compares free runs.

`python -m service.live.tracing_job FOLDER`.

The folder holds `job.json` and `streams.npz`; the answer is written there as `answer.json`. Exit status 0 done, 2 the
data cannot answer (one sentence on standard error). It stands back behind everything else on the machine, and is
bounded in memory, processor time and the size of files. When the learner is gone, so is this process, with its folder.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from incsvr.errors import BadInput
from service.live.background import MAX_MEMORY_BYTES, end_with_the_parent, stand_back

NICENESS = 10
"""The step by which it stands back: it still gets a tenth of a core that others want as a whole."""
MAX_PROCESSOR_S = 600
"""Processor time of the process [s]: the slowest trace known took 24."""


def main(folder: Path) -> int:
    stand_back(NICENESS, MAX_PROCESSOR_S)
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
