"""A log and what is said of it become measurements: the vehicle, the proposal, the tables, the streams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.column_spec import ColumnSpec, parse_columns
from service.inputs.measured_streams import MeasuredStreams, measure, topics_read
from service.inputs.owners import system_of
from service.inputs.presets import Observation, Proposal, propose
from service.inputs.presets.columns import time_column
from service.inputs.presets.proposal import Change
from service.inputs.settings import Inputs, Source, StampUnit
from service.inputs.stamp_fields import usual_stamp
from service.inputs.table import ROWS, Table
from service.inputs.units import STAMP_UNITS
from service.logs import cutting, naming, self_description
from service.logs.choosing import choose_vehicle
from service.logs.log import Log
from service.logs.parameters import ParameterEpoch, parameter_epochs

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


NO_DESCRIPTION = LogDescription((), Inputs())


def describe(log: Log, description: LogDescription) -> Proposal:
    """The mapping for a log: what a person says of it, and what the presets find beside that.

    Raises:
        BadInput: a person names what is not there.
    """
    choice = choose_vehicle(log, description.inputs)
    ours = [topic for topic in log.topics if system_of(topic) not in choice.others]
    said = parse_columns(description.columns, ours, [topic for topic in log.topics if topic not in ours])
    inputs = naming.with_log_names(description.inputs, ours)
    tables = log.read(names) if (names := self_description.names(ours)) else {}
    parts = parameter_epochs(ours, tables)
    vehicle, absent = self_description.of_vehicle(ours, tables), self_description.absent_batteries(ours, tables)
    proposals = [
        propose(Observation(ours, {**inputs.parameters, **part.parameters}, vehicle, absent), inputs.preset)
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


def read(path: Path, log: Log, proposal: Proposal) -> MeasuredStreams:
    """The measurements.

    Raises:
        BadInput: something is missing, with its cure.
    """
    if proposal.missing:
        raise BadInput(f"{path}: {next(iter(proposal.missing.values()))}")
    inputs, changes = proposal.inputs, proposal.changes
    used = topics_read(inputs, *(change.thrusters for change in changes if change.thrusters is not None))
    try:
        found = measure(inputs, log.read(used), changes)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    return replace(found, notes=(*found.notes, *log.notes))


def writing_times(table: Table, inputs: Inputs) -> Array:
    """The times of writing of the messages [s]; of a table its column of time."""
    if table.arrival is not None:
        return table.arrival
    source = inputs.yaw_rate or inputs.torque
    stamp, unit = ("t", "s") if source is None else (source.stamp, source.stamp_unit)
    stamps = table.columns.get(stamp)
    if stamps is None:
        return np.empty(0)
    return stamps * STAMP_UNITS[unit if unit != "s" else guessed_unit(stamps)]


def since_1970(log: Log, inputs: Inputs, measured: MeasuredStreams) -> float | None:
    """The offset of the measurements' stamps to seconds since 1970 [s]; None if the log does not show it."""
    if inputs.yaw_rate is None:
        return None
    table = log.read([inputs.yaw_rate.topic])[inputs.yaw_rate.topic]
    return cutting.since_1970(measured.streams["yaw_rate"][0], table.arrival)


def _stamped(proposal: Proposal, found: Inputs, said: ColumnSpec, log: Log) -> Proposal:
    """The sources of a table all have its time; one whose unit nobody named is told from the numbers.

    What a person pointed at in another log is stamped as the preset stamps that topic, or by the topic's usual stamp.
    """
    inputs, missing, notes = proposal.inputs, dict(proposal.missing), list(proposal.notes)
    stamps: dict[str, tuple[str, StampUnit]] = {}
    for each in (found, inputs):
        for source in (each.yaw_rate, each.torque, each.thrusters, *each.channels.values()):
            if source is not None and source.stamp:
                stamps[source.topic] = (source.stamp, source.stamp_unit)
    armed = inputs.armed
    if armed is not None and armed.topic in stamps:
        armed = armed.model_copy(update=dict(zip(("stamp", "stamp_unit"), stamps[armed.topic], strict=True)))
    usual = {topic.name: usual_stamp(topic.fields) for topic in log.topics if topic.name != ROWS}
    stamps = {name: stamp for name, stamp in usual.items() if stamp[0]} | stamps
    if [topic.name for topic in log.topics] == [ROWS]:
        table = log.read([ROWS])[ROWS]
        by_name = stamps.get(ROWS) or time_column(log.topics[0].fields) or ("", "s")
        stamp = said.stamp or by_name[0]
        if stamp:
            missing.pop("t", None)
            unit, note = _unit(said, stamp, by_name[1], table)
            stamps = {ROWS: (stamp, unit)}
            notes += note
            if armed is not None and armed.topic == ROWS:
                armed = armed.model_copy(update={"stamp": stamp, "stamp_unit": unit})
    changed = {name: _with_stamp(getattr(inputs, name), stamps) for name in ("yaw_rate", "torque")}
    channels = {name: _with_stamp(each, stamps) for name, each in inputs.channels.items()}
    thrusters = inputs.thrusters
    if thrusters is not None and not thrusters.stamp and thrusters.topics[0] in stamps:
        stamp, unit = stamps[thrusters.topics[0]]
        thrusters = thrusters.model_copy(update={"stamp": stamp, "stamp_unit": unit})
    after = inputs.model_copy(update={**changed, "channels": channels, "armed": armed, "thrusters": thrusters})
    return replace(proposal, inputs=after, missing=missing, notes=tuple(notes))


def _with_stamp(source: Source | None, stamps: Mapping[str, tuple[str, StampUnit]]) -> Source | None:
    if source is None or source.topic not in stamps or (source.stamp and source.topic != ROWS):
        return source
    stamp, unit = stamps[source.topic]
    return source.model_copy(update={"stamp": stamp, "stamp_unit": unit})


def _unit(said: ColumnSpec, stamp: str, named: StampUnit, table: Table) -> tuple[StampUnit, list[str]]:
    """The unit of a table's time: as it was said, as the column's name says, or by its steps and its size."""
    for unit in STAMP_UNITS:
        if unit == (said.stamp_unit or (named if named != "s" else None)):
            return unit, []  # type: ignore[return-value]
    time = table.columns.get(stamp)
    if time is None or said.stamp_unit == "s":
        return "s", []
    guess = guessed_unit(time)
    return guess, [] if guess == "s" else [f"the time {stamp!r} is read as {guess}, by its steps"]


def guessed_unit(time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> StampUnit:
    """The unit of stamps (n,): those since 1970 by their size, others by their typical step."""
    known = time[np.isfinite(time)]
    if not known.size:
        return "s"
    size = float(np.median(np.abs(known)))
    units: tuple[StampUnit, ...] = ("s", "ms", "us", "ns")
    for unit in units:
        if cutting.MIN_STAMP_SINCE_1970_S <= size * STAMP_UNITS[unit] < 10.0 * cutting.MIN_STAMP_SINCE_1970_S and (
            unit != "s" or _step(known) <= MAX_STEP_S
        ):
            return unit
    return next((unit for unit in units if _step(known) * STAMP_UNITS[unit] <= MAX_STEP_S), "ns")


def _step(time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    steps = np.diff(np.unique(time))
    return float(np.median(steps)) if steps.size else 0.0
