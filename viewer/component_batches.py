"""Points, boxes and lines for the recording, straight from arrays: the SDK's own way takes half an iteration's time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from rerun.components import LineStrip2DBatch, Position2DBatch, ScalarBatch

from viewer.frame import Floats

Lines = Sequence[Floats] | Floats
"""Lines through (n, 2) points each, or (m, n, 2) for m lines of equal length."""
NONE: Floats = np.empty((0, 2, 2))


class ComponentBatches:
    """Arrow arrays with the descriptors of what they are, as Rerun's `log` takes them."""

    def __init__(self, *batches: rr.DescribedComponentBatch) -> None:
        self._batches = list(batches)

    def as_component_batches(self) -> list[rr.DescribedComponentBatch]:
        return self._batches


def points(at: Floats) -> ComponentBatches:
    """Points2D at (n, 2); coordinates become 32-bit floats in the recording."""
    return ComponentBatches(_vectors(at, *_POSITIONS))


def boxes(at: Floats, half_size: tuple[float, float]) -> ComponentBatches:
    """Boxes2D of one size around (n, 2)."""
    halves = np.empty_like(at)
    halves[:] = half_size
    return ComponentBatches(_vectors(halves, *_HALF_SIZES), _vectors(at, *_CENTRES))


def strips(lines: Lines) -> ComponentBatches:
    """LineStrips2D."""
    if isinstance(lines, np.ndarray):
        ends, flat = np.arange(0, lines.size // 2 + 1, lines.shape[1]), lines
    else:
        ends = np.zeros(len(lines) + 1, dtype=np.intp)
        ends[1:] = np.cumsum([len(line) for line in lines])
        flat = np.concatenate(lines) if lines else NONE
    kind, descriptor = _STRIPS
    inner = pa.FixedSizeListArray.from_arrays(pa.array(flat.astype(np.float32).ravel()), type=kind.value_type)
    array = pa.ListArray.from_arrays(pa.array(ends.astype(np.int32)), inner, type=kind)
    return ComponentBatches(rr.DescribedComponentBatch(_Ready(array), descriptor))


def scalars(values: Sequence[float] | Floats) -> list[rr.ComponentColumn]:
    """A column of Scalars, one in each row."""
    kind, descriptor = _SCALARS
    array = pa.array(np.asarray(values, dtype=np.float64), type=kind)
    return [rr.DescribedComponentBatch(_Ready(array), descriptor).partition()]


def dashed(line: Floats, dash: float | None) -> list[Floats]:
    """The (n, 2) line, n ≥ 0, in dashes of this length along x with shorter gaps; None is the whole line."""
    if len(line) < 2:
        return []
    if dash is None:
        return [line]
    x = np.arange(line[0, 0], line[-1, 0], dash / 4.0)
    fine = np.column_stack((x, np.interp(x, line[:, 0], line[:, 1])))
    return [fine[k : k + 5] for k in range(0, len(fine) - 1, 7)]


class _Ready:
    """An arrow array that needs no conversion."""

    def __init__(self, array: pa.Array) -> None:
        self._array = array

    def as_arrow_array(self) -> pa.Array:
        return self._array


def _vectors(at: Floats, kind: Any, descriptor: rr.ComponentDescriptor) -> rr.DescribedComponentBatch:
    flat = pa.array(at.astype(np.float32).ravel())
    return rr.DescribedComponentBatch(_Ready(pa.FixedSizeListArray.from_arrays(flat, type=kind)), descriptor)


def _descriptor(archetype: Any, number: int = 0) -> rr.ComponentDescriptor:
    batch: rr.DescribedComponentBatch = archetype.as_component_batches()[number]
    return batch.component_descriptor()


_BOX = rr.Boxes2D.from_fields(half_sizes=[[1.0, 1.0]], centers=[[0.0, 0.0]])
_VECTOR = Position2DBatch._ARROW_DATATYPE
_POSITIONS = _VECTOR, _descriptor(rr.Points2D.from_fields(positions=[[0.0, 0.0]]))
_HALF_SIZES = _VECTOR, _descriptor(_BOX, 0)
_CENTRES = _VECTOR, _descriptor(_BOX, 1)
_SCALARS = ScalarBatch._ARROW_DATATYPE, _descriptor(rr.Scalars(0.0))
_STRIPS = LineStrip2DBatch._ARROW_DATATYPE, _descriptor(rr.LineStrips2D.from_fields(strips=[[[0.0, 0.0], [1.0, 1.0]]]))
