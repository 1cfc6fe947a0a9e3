"""Dives of whole vehicles under commands that hold, and a log of one to try `incsvr identify` on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from incsvr.numerics import Streams
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator.mission import Mission
from simulator.sensors import whole
from simulator.vehicles import BODIES, Vehicle
from simulator.world import play_together

LOG_DURATION_S = 300.0
"""Length of the log [s]."""
_BODY_SEED = 1
"""Seed of the vehicle, so that logs of other seeds are dives of the same vehicle."""


def dives(
    vehicles: Sequence[Vehicle],
    seconds: float,
    seed: int,
    current: tuple[float, float] = (0.0, 0.0),
    along: float = 0.005,
    about: float = 0.003,
    water: float = 1.0,
) -> list[Streams]:
    """The logs of dives of equal length, one of each vehicle: velocities over ground, efforts, roll, pitch and heading.

    Args:
        vehicles: that dive.
        seconds: length of a dive [s].
        seed: of the first; the others' follow.
        current: velocity of the water to north and east [m/s].
        along, about: white noise of velocities [m/s], [rad/s].
        water: 1 for water that pushes as usual, 0 for still water.
    """
    missions = (
        Mission(
            vehicle, "holds", seed + k, duration=seconds, current=current, water=water,
            sensing=lambda each, _: whole(each, along=along, about=about),
        )
        for k, vehicle in enumerate(vehicles)
    )  # fmt: skip
    return [outcome.recording.streams() for outcome in play_together(missions)]


def write_dive(path: Path, vehicle: str, seed: int) -> Vehicle:
    """Writes a dive under random commands; returns the vehicle that dived.

    Args:
        vehicle: a name of `BODIES`.
        seed: draws the commands and the noise.

    Raises:
        OSError: the file cannot be written.
    """
    body = BODIES[vehicle](np.random.default_rng(_BODY_SEED))
    (log,) = dives([body], LOG_DURATION_S, seed)
    write(path, Recording(path.stem, log))
    return body
