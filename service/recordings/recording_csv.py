"""Recordings as CSV files of one contiguous run each, written exactly.

Header row; `t` [s], never going back; `yaw_rate` [rad/s]; `torque` [N m]; then any further numeric channels. An
empty cell (also `nan`, `NA`) means that the channel was not sampled in that row, so streams of different rates fit in
one file. Rows of one instant are merged. Of another axis than yaw its own columns (`sway`, `sway_force`) stand for
these two.
"""

from __future__ import annotations

import csv
from pathlib import Path

from service.recordings.recording import Recording


def write(path: Path, recording: Recording) -> None:
    """Writes a CSV file from which `incsvr.read` gives the same numbers to the last bit."""
    table = recording.columns
    columns = [recording.time.tolist(), *(values.tolist() for values in table.values())]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", *table])
        writer.writerows(["" if cell != cell else repr(cell) for cell in row] for row in zip(*columns, strict=True))
