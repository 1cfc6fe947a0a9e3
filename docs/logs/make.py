"""Writes the logs beside this file: a simulated small ROV turns for a minute, twice. Its reverse thrust is weak.

    python docs/logs/make.py

The vehicle's inertia with the water's is 0.6 kg m², and a moment to port (negative) is 0.7 of what the log shows.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from incsvr.plant.axes import YAW
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from simulator.leng_at_sea import REVERSE_EFFICIENCY
from simulator.mission import Mission
from simulator.physics import Physics, static
from simulator.vehicles import TURNING
from simulator.world import play

SECONDS, RATE_HZ = 60.0, 25.0
SEEDS = {"rov.csv": 7, "rov_2.csv": 8}
DIGITS = 5
"""Decimals in the files: finer than the gyro's noise."""


def log(name: str) -> Recording:
    """The log of this name."""
    weak = static(lambda moment: moment if moment > 0.0 else REVERSE_EFFICIENCY * moment)
    mission = Mission(
        TURNING["rov"], "telegraph", SEEDS[name], duration=SECONDS, beats=RATE_HZ, besides=Physics(stages=(weak,))
    )
    found = play(mission).recording
    columns = {each: np.round(found.columns[each], DIGITS) for each in (YAW.rate, YAW.effort)}
    return from_table(name, found.time, columns)


def main() -> None:
    for name in SEEDS:
        write(Path(__file__).parent / name, log(name))


if __name__ == "__main__":
    main()
