"""Streams between their stamps: integrals of a held or linear course, samples that are no measurement."""

from __future__ import annotations

import numpy as np

from incsvr.model_trace.thresholds import MAX_STAMP_ERROR_PERIODS, SPIKE_BENDS, SPIKE_NEIGHBOURS
from incsvr.numerics import Array


def without_spikes(values: Array) -> Array:
    """(n,) the values, single samples replaced that stand out of neighbours which lie on a line.

    The top of a fast turn stays, and so does everything of a stream that stands still most of the time.
    """
    if values.size < 5:
        return values
    middle = 0.5 * (values[1:-3] + values[3:-1])
    away = np.abs(values[2:-2] - middle)
    slope = 0.5 * (values[3:-1] - values[1:-3])
    beside = np.maximum(np.abs(values[1:-3] - values[:-4] - slope), np.abs(values[4:] - values[3:-1] - slope))
    usual = float(np.median(away))
    spike = (away > SPIKE_NEIGHBOURS * beside) & (away > SPIKE_BENDS * usual) & (usual > 0.0)
    out = values.copy()
    out[2:-2][spike] = middle[spike]
    return out


def snapped_edges(edges: Array, stamps: Array, step: float) -> Array:
    """(m,) the edges, or the stamps (n,) themselves where these are as even as a grid of `step` [s]."""
    nearest = stamps[np.clip(np.searchsorted(stamps, edges - 0.5 * step), 0, stamps.size - 1)]
    return nearest if float(np.max(np.abs(nearest - edges))) < MAX_STAMP_ERROR_PERIODS * step else edges
