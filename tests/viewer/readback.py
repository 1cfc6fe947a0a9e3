"""Reads recordings back, the way a viewer resolves them: the newest row at or before an iteration counts."""

from __future__ import annotations

import subprocess
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning

from viewer import window
from viewer.frame import Floats

Rows = dict[str, dict[int, Any]]


def verify(path: Path) -> None:
    """Has Rerun read the whole file."""
    done = subprocess.run([window.BINARY, "rrd", "verify", path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def chunks(path: Path, column: str, content: str, clock: str | None = None) -> Iterator[tuple[str, Any]]:
    """Entity and rows of each chunk with a column such as Points2D:positions, on a clock."""
    with warnings.catch_warnings():
        # A file that was cut off is read as it is; that it was is not news here.
        warnings.filterwarnings("ignore", message="RRD file has no footer", category=RerunWarning)
        reader = RrdReader(str(path))
    for entry in reader.recordings():
        on: dict[str, Any] = {} if clock is None else {"has_timeline": clock}
        for chunk in reader.stream(store=entry).filter(content=content, components=column, **on):
            yield chunk.entity_path, chunk.to_record_batch()


def rows(path: Path, column: str, under: str = "/learning") -> Rows:
    """Entity → iteration → the logged value of a column."""
    found: Rows = {}
    for entity, batch in chunks(path, column, f"{under}/**", "iteration"):
        pairs = zip(batch.column("iteration").to_pylist(), batch.column(column).to_pylist(), strict=True)
        found.setdefault(entity, {}).update((at, value) for at, value in pairs if value is not None)
    return found


def every(path: Path, column: str, entity: str) -> list[Any]:
    """All that was ever logged of a column there; `rows` keeps what was said last at an iteration."""
    batches = [batch for _, batch in chunks(path, column, entity)]
    return [value[0] for batch in batches for value in batch.column(column).to_pylist() if value is not None]


def series(path: Path, under: str) -> dict[str, list[float]]:
    """Entity → its scalars in the order of the vehicle's time."""
    found: dict[str, list[tuple[Any, float]]] = {}
    for entity, batch in chunks(path, "Scalars:scalars", f"{under}/**", "vehicle_time"):
        times = batch.column("vehicle_time").cast("int64").to_pylist()
        values = batch.column("Scalars:scalars").to_pylist()
        found.setdefault(entity, []).extend((at, value[0]) for at, value in zip(times, values, strict=True))
    return {entity: [value for _, value in sorted(pairs)] for entity, pairs in found.items()}


def shown(logged: dict[int, Any], iteration: int) -> Any:
    """What stands on the screen at an iteration; None where nothing was ever logged."""
    before = [at for at in logged if at <= iteration]
    return logged[max(before)] if before else None


def points(value: Any) -> Floats:
    return np.array(value, dtype=np.float64).reshape(-1, 2)
