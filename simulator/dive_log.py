"""A log of a simulated vehicle in six degrees of freedom, to try `incsvr identify` on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from service.recordings.recording import from_streams
from service.recordings.recording_csv import write
from simulator.six_degrees import BODIES, Body, swim

LOG_DURATION_S = 300.0
"""Length of the log [s]."""
_BODY_SEED = 1
"""Seed of the body, so that logs of other seeds are dives of the same vehicle."""


def write_dive(path: Path, vehicle: str, seed: int) -> Body:
    """Writes a dive under random commands; returns the vehicle that dived.

    Args:
        vehicle: a name of `BODIES`.
        seed: draws the commands and the noise.

    Raises:
        OSError: the file cannot be written.
    """
    body = BODIES[vehicle](np.random.default_rng(_BODY_SEED))
    write(path, from_streams(path.stem, swim(body, LOG_DURATION_S, np.random.default_rng([seed, *b"dive"]))))
    return body
