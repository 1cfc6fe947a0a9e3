"""The vehicle of a log that is used, by the rule of `service.inputs.vehicles`, over the messages as they arrived."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.inputs.settings import Inputs
from service.inputs.table import Table
from service.inputs.vehicles import (
    VehicleEvidence,
    Vehicles,
    evidence_of,
    named_vehicle,
    present_vehicles,
    refuse_unknown,
    vehicles_with_yaw_rate,
)
from service.logs.log import Log

NO_VEHICLE_NAMED = Inputs()


@dataclass(frozen=True, slots=True)
class VehicleChoice:
    """The vehicle that is taken.

    Attributes:
        system: its name; empty where nothing says whose messages there are.
        others: vehicles that are left alone.
        note: the choice in one sentence, where there was one.
    """

    system: str
    others: frozenset[str]
    note: tuple[str, ...]


def choose_vehicle(log: Log, inputs: Inputs = NO_VEHICLE_NAMED) -> VehicleChoice:
    """The vehicle of a log that is taken for all messages and parameters.

    Args:
        inputs: in which a person may name one; else the rule chooses.

    Raises:
        BadInput: there is no such vehicle.
    """
    wanted = named_vehicle(inputs)
    busiest = sorted(log.topics, key=lambda topic: -topic.count)
    candidates, everybody = vehicles_with_yaw_rate(busiest), present_vehicles(busiest, wanted)
    refuse_unknown(inputs.system, everybody)
    vehicles = Vehicles(wanted)
    vehicles.meet(candidates or everybody)
    if len(candidates) > 1 and not vehicles.is_settled:
        _look(log, set(candidates), vehicles)
    others = vehicles.others(everybody)
    return VehicleChoice(vehicles.chosen, others, (vehicles.note(others),) if others else ())


def _look(log: Log, candidates: set[str], vehicles: Vehicles) -> None:
    """Shows the vehicles' messages to the rule, one after the other, until it is settled."""
    signs = {topic.name: found for topic in log.topics if (found := evidence_of(topic)) is not None}
    signs = {name: found for name, found in signs.items() if found.system in candidates}
    tables = log.read(list(signs))
    rows = [(signs[name], table, row) for name, table in tables.items() for row in range(_arrival(table).size)]
    arrival = np.concatenate([_arrival(table) for table in tables.values()]) if tables else np.empty(0)
    for k in np.argsort(arrival, kind="stable"):
        found, table, row = rows[k]
        vehicles.take(found, _number(found, table, row))
        if vehicles.is_settled:
            return


def _arrival(table: Table) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.empty(0) if table.arrival is None else table.arrival


def _number(found: VehicleEvidence, table: Table, row: int) -> Callable[[str], float | None]:
    def number(path: str) -> float | None:
        column = table.columns.get(path)
        return None if column is None else float(column[row])

    return number
