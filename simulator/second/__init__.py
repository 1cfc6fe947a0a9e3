"""A second simulator, to test the tracer on what it was not fitted to.

Whoever improves a method on one simulator fits it to that simulator, too. This one has other vehicles, drag curves,
rates, controllers and sensors than the trial vehicle (simulator/trial.py), and most of its effects have another shape
than the catalogue that looks for them. It was written anew and shares no line with the trial vehicle, the missions or
the tracer; only the form of a recording is common. Its cases are in benchmarks/tracer/second_cases.py.
"""

from __future__ import annotations

from simulator.second.commands import CLOSED_LOOP, COMMANDS, OPEN_LOOP
from simulator.second.hidden import BY_CHANNEL, EFFECTS
from simulator.second.play import Case, Outcome, play
from simulator.second.vehicles import VEHICLES, Vehicle

__all__ = [
    "BY_CHANNEL",
    "CLOSED_LOOP",
    "COMMANDS",
    "EFFECTS",
    "OPEN_LOOP",
    "VEHICLES",
    "Case",
    "Outcome",
    "Vehicle",
    "play",
]
