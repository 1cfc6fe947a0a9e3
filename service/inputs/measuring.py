"""The mapping at work: tables of messages become streams in SI units on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.samples import Array
from service.inputs.arming import says_armed
from service.inputs.clocks import Clock
from service.inputs.settings import ARRIVAL, Armed, Inputs, Source, Thrusters
from service.inputs.thrust import T200_NOMINAL, moment, sensible
from service.inputs.units import STAMPS
from service.logs.table import Table

Stream = tuple[Array, Array]
SURGE = "surge"


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured.

    Attributes:
        streams: stamps (n,) [s], strictly increasing, and values (n,) in SI units by name: yaw_rate, torque, channels.
        armed: stamps (n,) [s] and whether the thrusters may turn from then on; None where nothing says so.
        notes: what a person should know of how it came about, one sentence each.
    """

    streams: Mapping[str, Stream]
    armed: Stream | None
    notes: tuple[str, ...]


def topics(inputs: Inputs) -> frozenset[str]:
    """The topics that the mapping reads."""
    sources: list[Source | Armed | None] = [
        inputs.yaw_rate,
        inputs.torque,
        inputs.armed,
        *inputs.channels.values(),
        *(inputs.thrusters.beside() if inputs.thrusters else ()),
    ]
    commands = inputs.thrusters.topics if inputs.thrusters else ()
    return frozenset(each.topic for each in sources if each is not None) | frozenset(commands)


def measured(inputs: Inputs, tables: Mapping[str, Table]) -> Measured:
    """The streams of the mapping.

    Raises:
        BadInput: a topic or a field of it is not there.
    """
    if inputs.yaw_rate is None:
        raise BadInput("nothing says where the yaw rate stands")
    table = _table(inputs.yaw_rate.topic, tables)
    stamps = _stamps(inputs.yaw_rate, inputs.yaw_rate.topic, table)
    clock = Clock.of(_arrival(table, stamps), stamps)
    notes: list[str] = []
    streams = {"yaw_rate": _stream("yaw_rate", inputs.yaw_rate, tables, clock, notes)}
    channels = {name: _stream(name, source, tables, clock, notes) for name, source in inputs.channels.items()}
    if inputs.torque is not None:
        streams["torque"] = _stream("torque", inputs.torque, tables, clock, notes)
    elif inputs.thrusters is not None:
        streams["torque"] = _torque(inputs.thrusters, tables, clock, channels.get(SURGE), notes)
    armed = None if inputs.armed is None else _armed(inputs.armed, tables, clock)
    return Measured(streams | {name: each for name, each in channels.items() if each[0].size}, armed, tuple(notes))


def _table(topic: str, tables: Mapping[str, Table]) -> Table:
    if topic not in tables:
        raise BadInput(f"there is no topic {topic}; `incsvr inspect FILE` lists what there is")
    return tables[topic]


def _column(field: str, topic: str, table: Table) -> Array:
    if field not in table.columns:
        known = ", ".join(list(table.columns)[:12])
        raise BadInput(f"there is no number {field} in {topic}, but {known}; `incsvr inspect FILE` lists them all")
    return table.columns[field]


def _stamps(source: Source | Thrusters | Armed, topic: str, table: Table) -> Array | None:
    """The stamps of a table by its own clock [s]; None where the time of arrival counts, or nobody set the stamps."""
    if source.stamp in ("", ARRIVAL):
        return None
    stamps = _column(source.stamp, topic, table) * STAMPS[source.stamp_unit]
    known = stamps[np.isfinite(stamps)]
    return stamps if known.size and (known.size == 1 or np.ptp(known) > 0.0) else None


def _arrival(table: Table, stamps: Array | None) -> Array:
    """When the messages were written down [s]; their stamps where only they tell."""
    arrival = stamps if table.arrival is None else table.arrival
    if arrival is None:
        raise BadInput(
            "nothing says when the rows were measured: name the column of the time, as in --column t=stamp:ms"
        )
    return arrival


def _stream(name: str, source: Source, tables: Mapping[str, Table], clock: Clock, notes: list[str]) -> Stream:
    table = _table(source.topic, tables)
    values = _column(source.field, source.topic, table) * source.factor
    return _ordered(_placed(name, source, source.topic, table, clock, notes), values)


def _placed(name: str, source: Source | Thrusters, topic: str, table: Table, clock: Clock, notes: list[str]) -> Array:
    stamps = _stamps(source, topic, table)
    ours = isinstance(source, Source) and source.form == "incsvr"
    time, own = clock.placed(_arrival(table, stamps), stamps, ours)
    if stamps is not None and not own:
        notes.append(f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival count")
    return time


def _ordered(time: Array, values: Array) -> Stream:
    """By rising stamps, each once, without what was not sampled."""
    kept = np.isfinite(values) & np.isfinite(time)
    time, values = time[kept], values[kept]
    order = np.argsort(time, kind="stable")
    unique, first = np.unique(time[order], return_index=True)
    return unique, values[order][first]


def _torque(
    settings: Thrusters, tables: Mapping[str, Table], clock: Clock, surge: Stream | None, notes: list[str]
) -> Stream:
    """The moment of all thrusters from their commands, at the times of the first one's; those of others hold."""
    first = settings.topics[0]
    time = _placed("torque", settings, first, _table(first, tables), clock, notes)
    commands = []
    for each, topic in zip(settings.each, settings.topics, strict=True):
        table = _table(topic, tables)
        told = _column(each.field, topic, table)
        if topic != first:
            stamps, values = _ordered(_placed("torque", settings, topic, table, clock, notes), told)
            at = np.searchsorted(stamps, time, side="right") - 1
            told = np.where(at >= 0, values[np.maximum(at, 0)], np.nan) if values.size else np.full(time.size, np.nan)
        commands.append(told)
    volts = _volts(settings, tables, clock, time, notes)
    speed = np.zeros(time.size) if surge is None or not surge[0].size else np.interp(time, *surge)
    angles = {}
    for k, each in enumerate(settings.each):
        if each.turned_by is not None:
            angles[k] = np.interp(
                time, *_stream(f"the angle of {each.turned_by.topic}", each.turned_by, tables, clock, notes)
            )
    return _ordered(time, moment(settings, commands, volts, speed, angles))


def _volts(settings: Thrusters, tables: Mapping[str, Table], clock: Clock, time: Array, notes: list[str]) -> Array:
    if settings.measured_voltage is not None and settings.measured_voltage.topic in tables:
        stamps, volts = _stream("voltage", settings.measured_voltage, tables, clock, notes)
        real = sensible(volts)
        if real.any():
            return np.interp(time, stamps[real], volts[real])
    if settings.voltage is None and settings.curve == "t200":
        notes.append(f"nothing says the battery's voltage: the thrust is that at {T200_NOMINAL:g} V")
    return np.full(time.size, T200_NOMINAL if settings.voltage is None else settings.voltage)


def _armed(settings: Armed, tables: Mapping[str, Table], clock: Clock) -> Stream | None:
    table = tables.get(settings.topic)
    if table is None or settings.field not in table.columns:
        # What tells changes alone and never spoke did not arm.
        return (np.array([0.0]), np.zeros(1)) if settings.events else None
    values = table.columns[settings.field]
    armed = says_armed(settings, values)
    stamps = _stamps(settings, settings.topic, table)
    time, _ = clock.placed(_arrival(table, stamps), stamps)
    if settings.events:
        time, armed = np.concatenate(([-np.inf], time)), np.concatenate(([False], armed))
    return time, armed.astype(np.float64)
