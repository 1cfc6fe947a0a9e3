"""The vehicle of a log that is used, by the rule of `service.inputs.vehicles`, over the messages as they arrived."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from incsvr.numerics import Array
from service.inputs.owners import AUTOPILOT
from service.inputs.settings import Inputs
from service.inputs.vehicles import (
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


def with_plain_names(log: Log) -> Log:
    """The log with the messages of the autopilot of the vehicle that is chosen by their plain names: `ATTITUDE`."""
    system = choose_vehicle(log).system
    plain = f"mavlink/{system}/{AUTOPILOT}/"
    topics = (
        replace(topic, name=topic.name.removeprefix(plain), system=system) if topic.name.startswith(plain) else topic
        for topic in log.topics
    )
    tables = {name.removeprefix(plain): table for name, table in log.tables.items()}
    return replace(log, topics=tuple(sorted(topics, key=lambda topic: topic.name)), tables=tables)


def _look(log: Log, candidates: set[str], vehicles: Vehicles) -> None:
    """Shows the vehicles' messages to the rule, one after the other, until it is settled."""
    signs = {topic.name: found for topic in log.topics if (found := evidence_of(topic)) is not None}
    signs = {name: found for name, found in signs.items() if found.system in candidates}
    tables = log.read(list(signs))
    tables = {name: table for name, table in tables.items() if table.arrival is not None}
    rows = [(signs[name], table.columns, row) for name, table in tables.items() for row in range(table.count)]
    arrival = np.concatenate([np.empty(0), *(each.arrival for each in tables.values() if each.arrival is not None)])
    for k in np.argsort(arrival, kind="stable"):
        sign, columns, row = rows[k]
        vehicles.take(sign, partial(_number, columns, row))
        if vehicles.is_settled:
            return


def _number(columns: Mapping[str, Array], row: int, path: str) -> float | None:
    return float(columns[path][row]) if path in columns else None
