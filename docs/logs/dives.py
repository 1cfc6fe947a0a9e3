"""Writes three dives of a simulated boat, a minute each. Before the last, all drags grow by a quarter.

python docs/logs/dives.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator.dive_log import dives
from simulator.vehicles import BODIES

SECONDS, FOULED = 60.0, 1.25


def main(folder: Path = Path()) -> list[Path]:
    """Writes the logs into a folder; their paths, in order."""
    boat = BODIES["boat"](np.random.default_rng(1))
    fouled = replace(boat, linear=FOULED * boat.linear, quadratic=FOULED * boat.quadratic)
    paths = [folder / f"{month}.csv" for month in ("april", "may", "june")]
    for path, log in zip(paths, dives([boat, boat, fouled], SECONDS, 1), strict=True):
        write(path, Recording(path.stem, log))
    return paths


if __name__ == "__main__":
    main()
