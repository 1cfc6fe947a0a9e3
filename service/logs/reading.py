"""A log and what is said of it become measurements: the vehicle, the proposal, the tables, the streams."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from service.inputs import self_description
from service.inputs.clocks import table_time
from service.inputs.column_spec import ColumnSpec, parse_columns, split_file
from service.inputs.columns import named_column, time_column
from service.inputs.lookup import propose
from service.inputs.measured_streams import MeasuredStreams, measure
from service.inputs.owners import autopilot_message, system_of
from service.inputs.proposal import Change, Observation, Proposal
from service.inputs.self_description import ParameterEpoch, parameter_epochs
from service.inputs.settings import Inputs, inside, renamed
from service.inputs.table import ROWS, Assumption, StampUnit, Table, Topic, usual_stamp
from service.inputs.units import STAMP_UNITS
from service.logs import cutting
from service.logs.candidates import ranks
from service.logs.cells import first_unread
from service.logs.choosing import choose_vehicle
from service.logs.cutting import Cut, Span, refuse_empty, streams_inside
from service.logs.log import Log


def with_log_names(inputs: Inputs, topics: Sequence[Topic]) -> Inputs:
    """The mapping with topics and paths as they are in a log; those of the vehicle's autopilot may be named by message.

    Args:
        topics: of the vehicle that is taken.
    """
    by_message = {message: topic for topic in topics if (message := autopilot_message(topic)) is not None}
    known = {**{topic.name: topic for topic in topics}, **by_message}

    def places(name: str, source: Any, topic: str) -> dict[str, Any]:
        if topic not in known:
            return {}
        paths = {each: inside(getattr(source, each, ""), known[topic].fields) for each in ("field", "stamp")}
        return {"topic": known[topic].name, **paths}

    return renamed(inputs, places)


MAX_STEP_S = 2.0
"""The longest typical step of stamps in seconds [s]; and likewise for the smaller units."""


@dataclass(frozen=True, slots=True)
class LogDescription:
    """A person's description of logs, which adds to the logs' own.

    Attributes:
        columns: texts of `--column`.
        inputs: the section of a configuration, with the preset.
    """

    columns: Sequence[str]
    inputs: Inputs

    def of(self, name: str) -> LogDescription:
        """The description of one log by its name: the flags for all, and those for it alone."""
        split = [split_file(text) for text in self.columns]
        if not any(file for file, _ in split):
            return self
        own = {rest.partition("=")[0] for file, rest in split if file == name}
        kept = [rest for file, rest in split if file == name or (not file and rest.partition("=")[0] not in own)]
        return replace(self, columns=tuple(kept))


NO_DESCRIPTION = LogDescription((), Inputs())


def describe(log: Log, description: LogDescription, axis: Axis = YAW) -> Proposal:
    """The mapping for a log: what a person says of it, and what the presets find beside that.

    Raises:
        BadInput: a person names what is not there.
    """
    choice = choose_vehicle(log, description.inputs)
    ours = [topic for topic in log.topics if system_of(topic) not in choice.others]
    others = [topic for topic in log.topics if topic not in ours]
    said = parse_columns(description.columns, ours, others, axis)
    inputs = with_log_names(description.inputs, ours)
    tables = log.read(names) if (names := self_description.names(ours)) else {}
    parts = parameter_epochs(ours, tables)
    vehicle, absent = self_description.of_vehicle(ours, tables), self_description.absent_batteries(ours, tables)
    known = ranks(log, ours)
    proposals = [
        propose(
            Observation(ours, {**inputs.parameters, **part.parameters}, vehicle, absent, known, axis), inputs.preset
        )
        for part in parts
    ]
    found = _with_changes(parts, proposals)
    found = replace(found, notes=choice.note)
    return _stamped(found.with_inputs(inputs).with_inputs(said.inputs), found.inputs, said, log)


def _with_changes(parts: Sequence[ParameterEpoch], proposals: Sequence[Proposal]) -> Proposal:
    """The first proposal that has thrusters, with what they change to under way."""
    first = next((each for each in proposals if each.inputs.thrusters is not None), proposals[0])
    changes: list[Change] = []
    now = first.inputs.thrusters
    words: tuple[str, ...] = ()
    for part, each in zip(parts, proposals, strict=True):
        words += part.changes
        if each.inputs.thrusters != now:
            now = each.inputs.thrusters
            changes.append(Change(part.since, now, words))
            words = ()
    return replace(first, changes=tuple(changes))


def read(path: Path, log: Log, proposal: Proposal, axis: Axis = YAW) -> MeasuredStreams:
    """The measurements.

    Raises:
        BadInput: something is missing, with its cure.
    """
    if proposal.missing:
        raise BadInput(f"{path}: {next(iter(proposal.missing.values()))}")
    inputs, changes = proposal.inputs, proposal.changes
    others = [each.places() for change in changes if (each := change.thrusters) is not None]
    names = {place.topic for place in (*inputs.places(), *chain(*others))}
    tables = log.read(names)
    try:
        found = measure(inputs, tables, changes, axis)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    assert inputs.yaw_rate is not None
    since = cutting.since_1970(found.streams[axis.rate][0], tables[inputs.yaw_rate.topic].arrival)
    return replace(
        found, notes=(*found.notes, *log.notes_on({*names, *self_description.names(log.topics)})), since_1970=since
    )


def writing_times(table: Table, inputs: Inputs) -> Array:
    """The times of writing of the messages [s]; of a table its column of time."""
    if table.arrival is not None:
        return table.arrival
    source = inputs.yaw_rate or inputs.torque
    stamp, unit = ("t", "s") if source is None else (source.stamp, source.stamp_unit)
    if stamp not in table.columns:
        return np.empty(0)
    stamps, _ = table_time(table, stamp)
    return stamps * STAMP_UNITS[unit if unit != "s" else guessed_unit(stamps)]


def _stamped(proposal: Proposal, found: Inputs, said: ColumnSpec, log: Log) -> Proposal:
    """The sources of a table all have its time; one whose unit nobody named is told from the numbers.

    What a person pointed at in another log is stamped as the preset stamps that topic, or by the topic's usual stamp.
    """
    inputs, missing, notes = proposal.inputs, dict(proposal.missing), list(proposal.notes)
    stamps: dict[str, tuple[str, StampUnit]] = {
        topic.name: usual for topic in log.topics if topic.name != ROWS and (usual := usual_stamp(topic.fields))[0]
    }
    stamped = [place for each in (found, inputs) for place in each.places() if place.stamp and place.name != "armed"]
    stamps |= {place.topic: (place.stamp, place.stamp_unit) for place in stamped}
    in_si: tuple[str, ...] = ()
    if [topic.name for topic in log.topics] == [ROWS]:
        table = log.read([ROWS])[ROWS]
        in_si = table.in_si
        dated: tuple[str, StampUnit] = (next(iter(table.instants), ""), "s")
        by_name = stamps.get(ROWS) or time_column(log.topics[0].fields) or dated
        stamp = said.stamp or by_name[0]
        if stamp:
            missing.pop("t", None)
            unit, note = ("s", []) if stamp in in_si else _unit(said, stamp, by_name[1], table)
            doubt = _wrong_unit(said, stamp, unit, table)
            if doubt is not None:
                missing["t"] = doubt
            stamps = {ROWS: (stamp, unit)}
            notes += note
        elif len(rising := _rising_columns(table)) == 1:
            unit = guessed_unit(table.columns[rising[0]])
            cure = shlex.quote(f"t={rising[0]}:{unit}")
            missing["t"] = f"no column is recognised as the time; if it is {rising[0]!r}, give --column {cure}"
        missing |= _unread(table, missing)

    def places(name: str, source: Any, topic: str) -> dict[str, Any]:
        already = name != "armed" and topic != ROWS and bool(getattr(source, "stamp", None))
        arrives = name == "armed" and topic not in {ROWS, *(place.topic for place in stamped)}
        if topic not in stamps or already or arrives:
            return {}
        again = {"unit": ""} if topic == ROWS and getattr(source, "field", None) in in_si else {}
        return dict(zip(("stamp", "stamp_unit"), stamps[topic], strict=True)) | again

    return replace(proposal, inputs=renamed(inputs, places), missing=missing, notes=tuple(notes))


def _rising_columns(table: Table) -> list[str]:
    """The columns of a table whose values never fall, and change."""
    known = {name: values[np.isfinite(values)] for name, values in table.columns.items()}
    return [name for name, each in known.items() if each.size > 2 and np.ptp(each) > 0.0 and (np.diff(each) >= 0).all()]


def _unread(table: Table, missing: Mapping[str, str]) -> dict[str, str]:
    """Sentences on what is missing because the column of that name holds texts."""
    found = {}
    for name in missing:
        column = named_column(tuple(table.texts), name)
        if column is None:
            continue
        row = first_unread(table.texts[column])
        how = (
            "time: write seconds, or ISO 8601 as in 2024-05-01T12:00:00.05"
            if name == "t"
            else "number: correct it, or leave the cell empty"
        )
        found[name] = f"row {row + 2}: {column!r} is {table.texts[column][row]!r}, which is read as no {how}"
    return found


def _unit(said: ColumnSpec, stamp: str, named: StampUnit, table: Table) -> tuple[StampUnit, list[str]]:
    """The unit of a table's time: as it was said, as the column's name says, or by its steps and its size."""
    for unit in STAMP_UNITS:
        if unit == (said.stamp_unit or (named if named != "s" else None)):
            return unit, []  # type: ignore[return-value]
    time = table.columns.get(stamp)
    if time is None or said.stamp_unit == "s":
        return "s", []
    guess = guessed_unit(time)
    if guess == "s" and _may_be_minutes(time[np.isfinite(time)]):
        span, cure = float(np.nanmax(time) - np.nanmin(time)), shlex.quote(f"t={stamp}:min")
        return guess, [Assumption(f"the time {stamp!r} is read as s, {span:.2g} in all (if min: --column {cure})")]
    how = "days, by its size" if guess == "d" else f"{guess}, by its steps"
    cure = shlex.quote(f"t={stamp}:{guess}")
    return guess, [] if guess == "s" else [Assumption(f"the time {stamp!r} is read as {how} (--column {cure})")]


MIN_STEP_S = 2e-4
"""The shortest typical step of a table [s]: no vehicle's log is faster than 5 kHz."""
USUAL_STEP_S = 0.05
"""A usual step of a table [s], to which a unit of the time leads."""
MIN_LOG_S, MAX_STEP_IN_MINUTES = 5.0, 4e-3
"""A log that is shorter may count minutes where its steps are at most so long, a quarter of a second."""
MIN_ROWS = 50
"""Rows of a table that has a usual step: of a few any step may be meant."""
LONGER_UNITS: tuple[StampUnit, ...] = ("d", "h", "min")
DAY_NUMBERS = ((36_526.0, 73_051.0), (730_486.0, 767_011.0))
"""Days since 1900 as spreadsheets count them, and since the year 0 as MATLAB does, from 2000 to 2100."""


def _may_be_minutes(time: Array) -> bool:
    """Whether stamps (n,) without a unit may be minutes: a log would be short, or its steps round in minutes alone."""
    step = _step(time)
    if not MIN_STEP_S <= step < MAX_STEP_IN_MINUTES:
        return False
    tenths, milliseconds = 1e4 * step, 60e3 * step
    is_round = abs(milliseconds - round(milliseconds)) < 0.01 < abs(tenths - round(tenths))
    return is_round or float(np.ptp(time)) < MIN_LOG_S


def _wrong_unit(said: ColumnSpec, stamp: str, unit: StampUnit, table: Table) -> str | None:
    """The doubt about a unit that stands in the time's name and makes the log faster, or slower, than any."""
    time = table.columns.get(stamp)
    if said.stamp_unit is not None or time is None or stamp in table.instants:
        return None
    step, guess = _step(time[np.isfinite(time)]), guessed_unit(time)
    if step <= 0.0 or MIN_STEP_S <= step * STAMP_UNITS[unit] <= MAX_STEP_S:
        return None
    if guess == unit:
        if time.size < MIN_ROWS:
            return None
        guess = min(LONGER_UNITS, key=lambda each: abs(np.log(step * STAMP_UNITS[each] / USUAL_STEP_S)))
    span = float(np.nanmax(time) - np.nanmin(time)) * STAMP_UNITS[unit]
    cure = shlex.quote(f"t={stamp}:{guess}")
    named = ", as its name says" if unit != "s" or guess not in LONGER_UNITS else ""
    return (
        f"the time {stamp!r} is read as {unit}{named}: the log would last {span:.2g} s, at a step of "
        f"{step * STAMP_UNITS[unit]:.2g} s; if it is in {guess}, give --column {cure}"
    )


def guessed_unit(time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> StampUnit:
    """The unit of stamps (n,): those since 1970 by their size, others by their typical step."""
    known = time[np.isfinite(time)]
    if not known.size:
        return "s"
    size = float(np.median(np.abs(known)))
    units: tuple[StampUnit, ...] = ("s", "ms", "us", "ns")
    if _step(known) < MIN_STEP_S and any(low <= size < high for low, high in DAY_NUMBERS):
        return "d"
    for unit in units:
        if cutting.MIN_STAMP_SINCE_1970_S <= size * STAMP_UNITS[unit] < 10.0 * cutting.MIN_STAMP_SINCE_1970_S and (
            unit != "s" or _step(known) <= MAX_STEP_S
        ):
            return unit
    return next((unit for unit in units if _step(known) * STAMP_UNITS[unit] <= MAX_STEP_S), "ns")


def _step(time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    steps = np.diff(time)
    if not (steps > 0.0).all():
        steps = np.diff(np.unique(time))
    return float(np.median(steps)) if steps.size else 0.0


def cut_log(
    topics: Sequence[Topic],
    tables: Mapping[str, Table],
    inputs: Inputs,
    measured: MeasuredStreams | None,
    cut: Cut,
) -> tuple[tuple[Topic, ...], dict[str, Table], MeasuredStreams | None]:
    """Topics, messages and measurements that a cut holds. Messages are cut by the time at which they were written.

    What says whether the vehicle was armed is kept whole: it holds on from before the cut.

    Args:
        measured: of the whole log; None where no yaw rate was found.

    Raises:
        EmptyCut: it holds nothing.
        BadInput: it is a time of day, and nothing says it.
    """
    written = {name: writing_times(table, inputs) for name, table in tables.items()}
    known = [time[np.isfinite(time)] for time in written.values()]
    every = np.concatenate([*known, np.empty(0)])
    shift = 0.0
    if measured is not None and measured.streams["yaw_rate"][0].size and inputs.yaw_rate is not None:
        stamps = measured.streams["yaw_rate"][0]
        span = Span(float(stamps[0]), float(stamps[-1]), measured.since_1970)
        arrival = written[inputs.yaw_rate.topic]
        shift = float(np.median(arrival[np.isfinite(arrival)]) - np.median(stamps)) if arrival.size else 0.0
    elif every.size:
        span = Span(float(every.min()), float(every.max()))
    else:
        return tuple(topics), dict(tables), measured
    low, high = cut.ends(span)
    if measured is not None:
        time = measured.streams["yaw_rate"][0]
        refuse_empty(cut, (time >= low) & (time <= high), span)
        streams = streams_inside(measured.streams, low, high)
        measured = replace(measured, streams={name: each for name, each in streams.items() if each[0].size})
    inside = {name: (time >= low + shift) & (time <= high + shift) for name, time in written.items() if time.size}
    cut_tables = {name: _rows(table, inside[name]) for name, table in tables.items() if name in inside}
    counts = {name: int(np.count_nonzero(rows)) for name, rows in inside.items()}
    cut_topics = tuple(replace(topic, count=counts.get(topic.name, topic.count)) for topic in topics)
    return cut_topics, {**tables, **cut_tables}, measured


def _rows(table: Table, inside: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Table:
    places = np.flatnonzero(inside)
    texts = {name: tuple(each[k] for k in places) for name, each in table.texts.items()}
    arrival = None if table.arrival is None else table.arrival[inside]
    return Table(arrival, {name: values[inside] for name, values in table.columns.items()}, texts)
