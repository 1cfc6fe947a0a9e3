"""Which missions are tried: groups of cases, each named by its group, what is asked and a seed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

from simulator.missions import KINDS, VEHICLES, Mission

HIDDEN = {
    "torque_lag": ("torque_lag",),
    "torque_delay": ("torque_delay",),
    "dead_zone": ("dead_zone",),
    "torque_asymmetry": ("torque_asymmetry",),
    "torque_saturation": ("torque_saturation",),
    "drag": ("drag_step", "drag_drift"),
    "bias_torque": ("bias_torque",),
    "inertia": ("inertia",),
    "heading_current": ("heading_current",),
}
"""What is hidden, by what counts as one effect; of two forms each second run has the other."""
SEED_STRIDE = 100
"""Between the seeds of a cell's runs; there are fewer cells, so that a new kind of mission moves no other's seeds."""
IDLE_KINDS = ("station", "on_deck")
"""Kinds in which the vehicle is hardly driven: nothing can be found there, and a refusal is right."""


@dataclass(frozen=True, slots=True)
class Circumstance:
    """How a run is logged: at which rate its controller works [Hz], and whether the log's gyro is another, of its own
    rate [Hz]."""

    name: str
    control_rate: float = 10.0
    separate_gyro: bool = False
    gyro_rate: float | None = None


USUAL_LOGS = (
    Circumstance("10 Hz, the controller's gyro"),
    Circumstance("10 Hz, another gyro", separate_gyro=True),
)
"""The first two runs of every cell."""
OTHER_LOGS = (
    Circumstance("5 Hz, the controller's gyro", control_rate=5.0),
    Circumstance("20 Hz, the controller's gyro", control_rate=20.0),
    Circumstance("commands at 4 Hz, another gyro at 20 Hz", control_rate=4.0, separate_gyro=True, gyro_rate=20.0),
)
"""Every further run has one of them; neighbouring cells begin with another one."""


def circumstance(mission: Mission) -> str:
    """The name of the circumstance under which a mission is logged."""
    return next(
        one.name
        for one in USUAL_LOGS + OTHER_LOGS
        if (one.control_rate, one.separate_gyro) == (mission.control_rate, mission.separate_gyro)
    )


def quiet(
    runs: int, first_seed: int, kinds: Collection[str] = KINDS, vehicles: Collection[str] = tuple(VEHICLES)
) -> Iterator[Mission]:
    """`runs` missions with nothing hidden of every kind and vehicle, each with a seed of its own."""
    cells = [(kind, vehicle) for kind in KINDS for vehicle in VEHICLES]
    for cell, (kind, vehicle) in enumerate(cells):
        for index in range(runs):
            seed = first_seed + cell + SEED_STRIDE * index
            if kind in kinds and vehicle in vehicles:
                yield _logged(Mission(kind, vehicle, seed), index, cell)


def hidden(kind: str, vehicle: str, runs: int, first_seed: int) -> Iterator[Mission]:
    """`runs` missions of one kind and vehicle for every effect of HIDDEN, each with a seed of its own."""
    for number, forms in enumerate(HIDDEN.values()):
        for index in range(runs):
            seed = first_seed + number + SEED_STRIDE * index
            yield _logged(Mission(kind, vehicle, seed, effect=forms[index % len(forms)]), index, number)


def _logged(mission: Mission, index: int, cell: int) -> Mission:
    how = USUAL_LOGS[index] if index < len(USUAL_LOGS) else OTHER_LOGS[(cell + index) % len(OTHER_LOGS)]
    return replace(mission, control_rate=how.control_rate, separate_gyro=how.separate_gyro, gyro_rate=how.gyro_rate)
