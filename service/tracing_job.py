"""The program of the process beside the learner: `python -m service.tracing_job FOLDER` traces, or compares free runs.

The folder holds `job.json` and `streams.npz`; the answer is written there as `answer.json`. Exit status 0 done, 2 the
data cannot answer (one sentence on standard error). Standard input is a pipe that the learner holds: when it closes,
the learner is gone, and so is this process, with its folder.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import threading
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.compensation import Compensation
from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.plant.axes import AXES
from incsvr.samples import Array
from incsvr.shadow import as_run, compare
from incsvr.signals import SignalSettings
from incsvr.tracing import trace
from incsvr.tracing.model import TracedModel

NICE = 10
"""By how much this process stands back behind the learner."""

Streams = Mapping[str, tuple[Array, Array]]


def main(folder: Path) -> int:
    os.nice(NICE)
    threading.Thread(target=_end_with_the_learner, args=(folder,), daemon=True).start()
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    with np.load(folder / "streams.npz") as kept:
        names = [name.removesuffix("/t") for name in kept.files if name.endswith("/t")]
        streams = {name: (kept[f"{name}/t"], kept[f"{name}/v"]) for name in names}
    try:
        answer = _compared(job, streams) if job["work"] == "prove" else _traced(job, streams)
    except BadInput as error:
        print(error, file=sys.stderr)
        return 2
    (folder / "answer.json").write_text(json.dumps(answer), encoding="utf-8")
    return 0


def _traced(job: Mapping[str, Any], streams: Streams) -> dict[str, Any]:
    """The same object as `incsvr trace --json` writes."""
    axis = AXES[job["axis"]]
    run = replace(as_run(streams), rate_name=axis.rate)
    return trace([run], inertia=job["inertia"]).told(axis).to_dict()


def _compared(job: Mapping[str, Any], streams: Streams) -> dict[str, Any]:
    signals = SignalSettings(**job["signals"] | {"channels": tuple(job["signals"]["channels"])})
    settings = Settings(**job["learner"] | {"rate_range": tuple(job["learner"]["rate_range"])})
    without = None if job["without"] is None else _compensation(job["without"])
    return asdict(compare(streams, job["fresh"], signals, settings, without, _compensation(job["effects"])))


def _compensation(trace: Mapping[str, Any]) -> Compensation:
    return Compensation.of(TracedModel.from_dict(trace["model"]))


def _end_with_the_learner(folder: Path) -> None:
    # Not through sys.stdin: its lock, held here, would abort the interpreter at its end.
    while os.read(0, 1):
        pass
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
