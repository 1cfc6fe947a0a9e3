"""The mapping at work: tables of messages become streams in SI units on one clock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import EFFORTS
from service.inputs.arming import says_armed, says_something
from service.inputs.clocks import Clock, pace, pace_note, set_at, table_time, without_unset
from service.inputs.marks import without_marks
from service.inputs.outputs import first_movement, least_movement, output, without_pulse
from service.inputs.presets.proposal import Change
from service.inputs.senders import SENDER, alternates, by_turns, sentence, two_clocks
from service.inputs.settings import ARRIVAL, Armed, Inputs, Source, Thrusters
from service.inputs.table import Assumption, Table
from service.inputs.thrust import T200_NOMINAL_V, is_battery_voltage, is_pulse, moment
from service.inputs.units import STAMP_UNITS


@dataclass(frozen=True, slots=True)
class CommandStream:
    """The commands of one thruster.

    Attributes:
        time: (n,) stamps [s], n ≥ 1, in any order.
        arrival: (n,) when each arrived [s].
        command: (n,) in the thruster's unit.
    """

    time: Array
    arrival: Array
    command: Array


def join_commands(streams: Sequence[CommandStream]) -> tuple[Array, Array, list[Array]]:
    """The commands of all thrusters, at each stamp of one of them.

    Returns:
        The stamps (n,) [s], rising, each once; when the last command of each stamp arrived (n,) [s]; the command of
        each thruster at that time, (n,) each, NaN before its first.
    """
    time = np.unique(np.concatenate([stream.time for stream in streams]))
    time = time[np.isfinite(time)]
    arrival = np.full(time.size, -np.inf)
    commands = []
    for stream in streams:
        order = np.argsort(stream.time, kind="stable")
        place = np.searchsorted(stream.time[order], time, side="right") - 1
        newest = order[np.maximum(place, 0)]
        commands.append(np.where(place >= 0, stream.command[newest], np.nan))
        own = (place >= 0) & (stream.time[newest] == time)
        arrival[own] = np.maximum(arrival[own], stream.arrival[newest[own]])
    return time, arrival, commands


def newest_at(arrival: Array, stream_arrival: Array, values: Array, before: float = np.nan) -> Array:
    """The newest of the values (m,) that had arrived at the times `arrival` (n,) [s]; `before` where none had."""
    if not values.size:
        return np.full(arrival.size, before)
    order = np.argsort(stream_arrival, kind="stable")
    place = np.searchsorted(stream_arrival[order], arrival, side="right") - 1
    return np.where(place >= 0, values[order][np.maximum(place, 0)], before)


def since_first_pulse(command: Array) -> Array:
    """The commands (n,) [µs] of an output from its first pulse on; NaN before it, where the output is not in use."""
    return np.where(np.maximum.accumulate(is_pulse(command)), command, np.nan)


Stream = tuple[Array, Array]
SURGE, VOLTAGE = "surge", "voltage"
MAX_CHANGES_NAMED = 6
"""Changes of parameters that are named."""


@dataclass(frozen=True, slots=True)
class MeasuredStreams:
    """The measured streams of a log, on one clock.

    Attributes:
        streams: stamps (n,) [s], strictly increasing, and values (n,) in SI units by name: yaw_rate, torque, channels.
        armed: stamps (n,) [s] and whether the thrusters may turn from then on; None where nothing says so.
        notes: what a person should know of how it came about, one sentence each.
        doubts: why nothing is to be learned of them, one sentence each.
    """

    streams: Mapping[str, Stream]
    armed: Stream | None
    notes: tuple[str, ...]
    doubts: tuple[str, ...] = ()


def topics_read(inputs: Inputs, *others: Thrusters) -> frozenset[str]:
    """The topics that the mapping reads, and those of thrusters that are others under way."""
    named: tuple[Inputs | Thrusters, ...] = (inputs, *others)
    return frozenset(place.topic for each in named for place in each.places())


def measure(inputs: Inputs, tables: Mapping[str, Table], changes: Sequence[Change] = ()) -> MeasuredStreams:
    """The streams of the mapping.

    Args:
        changes: of the thrusters under way.

    Raises:
        BadInput: a topic or a field of it is not there.
    """
    if inputs.yaw_rate is None:
        raise BadInput("the source of the yaw rate is not given")
    table = _table(inputs.yaw_rate.topic, tables)
    stamps = _stamps(inputs.yaw_rate, inputs.yaw_rate.topic, table)
    clock = Clock.of(_arrival(table, stamps), stamps)
    notes = [set_at(at) for at in clock.sets]
    if table.arrival is None and inputs.yaw_rate.stamp in table.columns:
        notes += table_time(table, inputs.yaw_rate.stamp)[1]
    streams = {"yaw_rate": _stream("yaw_rate", inputs.yaw_rate, tables, clock, notes)}
    channels = {name: _stream(name, source, tables, clock, notes) for name, source in inputs.channels.items()}
    moves = None
    if inputs.torque is not None:
        streams["torque"] = time, torque = _stream("torque", inputs.torque, tables, clock, notes)
        place = first_movement([torque], 0.0)
        moves = None if place is None else float(time[place])
    elif inputs.thrusters is not None:
        streams["torque"], moves = _torque(inputs, changes, tables, clock, notes)
    armed = _armed(inputs, tables, clock, moves, notes)
    there = {name: each for name, each in channels.items() if each[0].size}
    doubts = tuple(_two_senders(inputs, tables))
    return MeasuredStreams(streams | there, armed, tuple(dict.fromkeys((*doubts, *notes))), doubts)


def _two_senders(inputs: Inputs, tables: Mapping[str, Table]) -> Iterator[str]:
    """Sentences on a yaw rate, a torque or commands that two senders send, by their values or their clocks."""
    places = [
        (name, each, each.topic, each.field) for name in ("yaw_rate", "torque") if (each := getattr(inputs, name))
    ]
    if inputs.thrusters is not None:
        of_each = zip(inputs.thrusters.each, inputs.thrusters.topics, strict=True)
        places += [("a thruster's command", inputs.thrusters, topic, each.field) for each, topic in of_each]
    for name, source, topic, path in places:
        table = tables[topic]
        if path not in table.columns:
            continue
        stamps, values = _stamps(source, topic, table), table.columns[path]
        known = by_turns(table.columns[SENDER], values) if SENDER in table.columns else None
        time = _arrival(table, stamps) if stamps is None else stamps
        share = alternates(_rising(time, values)[1]) if known is None else known
        if share is not None:
            yield sentence(name, topic, share, known is not None)
        if table.arrival is not None and stamps is not None and two_clocks(table.arrival, stamps):
            yield (
                f"the stamps of {topic} are of two clocks by turns: two senders send {name} under one name; let one of "
                "them be silent, or give it a name of its own, and record again"
            )


def _table(topic: str, tables: Mapping[str, Table]) -> Table:
    if topic not in tables:
        raise BadInput(f"there is no topic {topic}; `incsvr inspect FILE` lists all")
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
    stamps = _column(source.stamp, topic, table)
    if table.arrival is None:
        stamps, _ = table_time(table, source.stamp)
    stamps = stamps * STAMP_UNITS[source.stamp_unit]
    if table.arrival is not None:
        stamps = without_unset(stamps)
    known = stamps[np.isfinite(stamps)]
    return stamps if known.size and (known.size == 1 or np.ptp(known) > 0.0) else None


def _arrival(table: Table, stamps: Array | None) -> Array:
    """The times of writing of the messages [s], or their stamps if there are no others."""
    unset = table.arrival is not None and stamps is not None and table.arrival.size > 1 and not np.ptp(table.arrival)
    arrival = stamps if table.arrival is None or unset else table.arrival
    if arrival is None:
        raise BadInput("no column of the time is known: name it, as in --column t=stamp:ms")
    return arrival


def _stream(name: str, source: Source, tables: Mapping[str, Table], clock: Clock, notes: list[str]) -> Stream:
    table = _table(source.topic, tables)
    values, note = without_marks(name, _column(source.field, source.topic, table), name in EFFORTS)
    notes += [] if note is None else [note]
    values = values * source.factor
    return _rising(_times(name, source, source.topic, table, clock, notes), values)


def _times(name: str, source: Source | Thrusters, topic: str, table: Table, clock: Clock, notes: list[str]) -> Array:
    stamps = _stamps(source, topic, table)
    ours = isinstance(source, Source) and source.form == "incsvr"
    time, own = clock.times_of(_arrival(table, stamps), stamps, ours)
    unset = 0 if stamps is None else int(np.isnan(stamps).sum())
    if unset and own:
        notes.append(f"{unset} of {time.size} messages of {topic} have no stamp: their times of arrival are used")
    if clock.pace != 1.0 and not own:
        notes.append(pace_note("yaw_rate", clock.pace))
    if stamps is not None and not own:
        if clock.of_arrival and (found := pace(_arrival(table, None), stamps)) != 1.0:
            raise BadInput(
                f"yaw_rate bears no stamp, and those of {name} run at {found:.3g} times the speed of the arrivals, "
                "as a simulator's do: record the yaw rate with stamps of that clock"
            )
        notes.append(f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival are used")
    return time


def _rising(time: Array, values: Array) -> Stream:
    """Sorts by stamps, keeps each once, and drops values that were not sampled."""
    kept = np.isfinite(values) & np.isfinite(time)
    time, values = time[kept], values[kept]
    order = np.argsort(time, kind="stable")
    unique, first = np.unique(time[order], return_index=True)
    return unique, values[order][first]


def _torque(
    inputs: Inputs, changes: Sequence[Change], tables: Mapping[str, Table], clock: Clock, notes: list[str]
) -> tuple[Stream, float | None]:
    """The moment of all thrusters from their commands, and when these first move [s]; None where they never do."""
    parts = [Change(-np.inf, inputs.thrusters, ()), *changes]
    streams: list[Stream] = []
    moves: list[float] = []
    for part, until in zip(parts, [*(change.since for change in changes), np.inf], strict=True):
        settings = part.thrusters
        if settings is None or part.since == until:
            continue
        time, arrival, commands = _commands(settings, tables, clock, notes)
        inside = (arrival >= part.since) & (arrival < until)
        time, arrival, commands = time[inside], arrival[inside], [command[inside] for command in commands]
        place = first_movement(commands, least_movement(settings))
        moves += [] if place is None else [float(time[place])]
        volts = _volts(settings, inputs, tables, arrival, notes)
        surge = _newest_before(inputs.channels[SURGE], tables, arrival, 0.0) if SURGE in inputs.channels else None
        turned = {k: each.turned_by for k, each in enumerate(settings.each) if each.turned_by is not None}
        angles = {k: _newest_before(source, tables, arrival) for k, source in turned.items()}
        speed = np.zeros(time.size) if surge is None else surge
        streams.append((time, moment(settings, commands, volts, speed, angles)))
    notes += _change_sentences(changes, clock)
    time, torque = (np.concatenate(each) for each in zip(*streams, strict=True))
    return _rising(time, torque), min(moves, default=None)


def _commands(
    settings: Thrusters, tables: Mapping[str, Table], clock: Clock, notes: list[str]
) -> tuple[Array, Array, list[Array]]:
    """The stamps [s] and times of arrival [s] of the thrusters' commands, and each thruster's command by then."""
    found, silent = [], []
    for k, (each, topic) in enumerate(zip(settings.each, settings.topics, strict=True)):
        an_output = settings.command == "pwm" and output(topic, each.field) is not None
        if an_output and each.field not in (tables[topic].columns if topic in tables else {}):
            silent.append(k)
            continue
        table = _table(topic, tables)
        command = _column(each.field, topic, table)
        if settings.command == "pwm":
            command = since_first_pulse(command)
        if an_output and np.isnan(command).all():
            silent.append(k)
        arrival = _arrival(table, _stamps(settings, topic, table))
        found.append(CommandStream(_times("torque", settings, topic, table, clock, notes), arrival, command))
    if silent:
        raise BadInput(without_pulse(settings, silent))
    return join_commands(found)


def _newest_before(source: Source, tables: Mapping[str, Table], arrival: Array, before: float = np.nan) -> Array:
    """The newest value of a quantity at the arrival (n,) [s] of commands, as on a bus."""
    table = _table(source.topic, tables)
    values = _column(source.field, source.topic, table) * source.factor
    known = np.isfinite(values)
    return newest_at(arrival, _arrival(table, _stamps(source, source.topic, table))[known], values[known], before)


def _volts(settings: Thrusters, inputs: Inputs, tables: Mapping[str, Table], arrival: Array, notes: list[str]) -> Array:
    """The battery's voltage (n,) [V] when commands arrived; before the first one was told, the first one."""
    source = settings.measured_voltage or inputs.channels.get(VOLTAGE)
    if source is not None and source.topic in tables:
        table = tables[source.topic]
        volts = _column(source.field, source.topic, table) * source.factor
        real = is_battery_voltage(volts)
        if real.any():
            return newest_at(
                arrival, _arrival(table, _stamps(source, source.topic, table))[real], volts[real], volts[real][0]
            )
    said = Assumption(
        f"the battery's voltage is unknown: the thrust is computed for {T200_NOMINAL_V:g} V "
        "(--column voltage=NAME gives it)"
    )
    if settings.voltage is None and settings.curve == "t200" and said not in notes:
        notes.append(said)
    return np.full(arrival.size, T200_NOMINAL_V if settings.voltage is None else settings.voltage)


def _change_sentences(changes: Sequence[Change], clock: Clock) -> list[str]:
    """The sentence on parameters that changed during the log."""
    said = []
    for change in changes:
        if change.parameters:
            at = float(clock.times_of(np.array([change.since]), None)[0][0])
            lost = " (the thrusters are not known then, and nothing is learned)" if change.thrusters is None else ""
            said.append(f"{', '.join(change.parameters)} from {at:.6g} s on{lost}")
    more = f"; and {len(said) - MAX_CHANGES_NAMED} more" if len(said) > MAX_CHANGES_NAMED else ""
    return (
        [f"parameters changed during the log, and apply from then on: {'; '.join(said[:MAX_CHANGES_NAMED])}{more}"]
        if said
        else []
    )


def _armed(
    inputs: Inputs, tables: Mapping[str, Table], clock: Clock, moves: float | None, notes: list[str]
) -> Stream | None:
    """The times and values of the armed state; before its first message it follows from moving outputs.

    Args:
        moves: when the outputs first move [s].
    """
    settings = inputs.armed
    if settings is None:
        return _by_movement("HEARTBEAT", moves, notes) if inputs.preset == "blueos" else None
    table = tables.get(settings.topic)
    if table is None or settings.field not in table.columns:
        return _by_movement(settings.topic, moves, notes) if settings.events else None
    values = table.columns[settings.field]
    told = says_something(settings, values)
    stamps = _stamps(settings, settings.topic, table)
    time, _ = clock.times_of(_arrival(table, stamps), stamps)
    time, armed = time[told], says_armed(settings, values)[told]
    if not settings.events:
        return time, armed.astype(np.float64)
    if not time.size:
        return _by_movement(settings.topic, moves, notes)
    before = np.array([-np.inf]), np.zeros(1, dtype=bool)
    if not armed[0] and moves is not None and moves < time[0]:
        before = np.array([-np.inf, moves]), np.array([False, True])
        notes.append(
            f"the log began while the vehicle was armed: its outputs move from {moves:.6g} s on, and the first "
            f"{settings.topic} reports it disarmed, at {time[0]:.6g} s"
        )
    return np.concatenate((before[0], time)), np.concatenate((before[1], armed)).astype(np.float64)


def _by_movement(topic: str, moves: float | None, notes: list[str]) -> Stream:
    """Armed from when the outputs first move, where nothing else says so; never where they never do."""
    if moves is None:
        return np.array([0.0]), np.zeros(1)
    notes.append(
        Assumption(
            f"no {topic} message shows whether the vehicle was armed, but its outputs move: it is assumed armed from "
            f"{moves:.6g} s on"
        )
    )
    return np.array([-np.inf, moves]), np.array([0.0, 1.0])
