"""The mapper over a whole log: what its tables show as a whole is known before the first message is mapped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import EFFORTS, YAW, Axis
from incsvr.plant.words import words_of
from service.inputs.arming import says_armed, says_something
from service.inputs.clocks import Clock, pace, pace_note, set_at, table_time, without_unset
from service.inputs.mapper import (
    NONE,
    FieldPlace,
    State,
    arrival_of,
    battery_of,
    has_unknown_voltage,
    real_values,
    silent_outputs,
    stamps_of,
    take,
)
from service.inputs.marks import without_marks
from service.inputs.outputs import output, without_pulse
from service.inputs.proposal import Change
from service.inputs.self_description import changes_note
from service.inputs.senders import SENDER, alternates, by_turns, sentence, two_clocks
from service.inputs.settings import ARRIVAL, Inputs, Place, Source, Thrusters
from service.inputs.table import ROWS, Assumption, Table
from service.inputs.thrust import T200_NOMINAL_V
from service.inputs.units import STAMP_UNITS
from service.inputs.values import Values

UNKNOWN_VOLTAGE = (
    f"the battery's voltage is unknown: the thrust is computed for {T200_NOMINAL_V:g} V "
    "(--column voltage=NAME gives it)"
)
MAX_CHANGES_NAMED = 6
"""Changes of parameters that are named."""


@dataclass(frozen=True, slots=True)
class MeasuredStreams:
    """The measured streams of a log, on one clock.

    Attributes:
        streams: stamps (n,) [s], strictly increasing, and values (n,) in SI units by name.
        armed: stamps (n,) [s] and whether the thrusters may turn from then on; None where nothing says so.
        notes: what a person should know of how it came about, one sentence each.
        doubts: why nothing is to be learned of them, one sentence each.
        since_1970: what makes seconds since 1970 of the stamps [s]; None where the log does not show it.
    """

    streams: Streams
    armed: Stream | None
    notes: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    since_1970: float | None = None


def measure(
    inputs: Inputs, tables: Mapping[str, Table], changes: Sequence[Change] = (), axis: Axis = YAW
) -> MeasuredStreams:
    """The streams of the mapping.

    Args:
        changes: of the thrusters under way.
        axis: whose velocity and effort `inputs.yaw_rate` and `inputs.torque` are.

    Raises:
        BadInput: a topic or a field of it is not there.
    """
    if inputs.yaw_rate is None:
        raise BadInput("the source of the yaw rate is not given")
    thrusters = [each for each in (inputs.thrusters, *(change.thrusters for change in changes)) if each is not None]
    places = list(dict.fromkeys((*inputs.places(), *(place for each in thrusters for place in each.places()))))
    _refuse_missing(places, tables)
    sources = inputs.sources_of(axis.rate, axis.effort)
    known, marks = _without_marks(sources, _with_whole_stamps(places, tables))
    doubts = tuple(_two_senders(inputs, known, axis))
    rate = known[inputs.yaw_rate.topic]
    stamps = stamps_of(inputs.yaw_rate, rate)
    clock = Clock.of(arrival_of(rate, stamps), stamps)
    notes = [set_at(at) for at in clock.sets]
    if rate.arrival is None and stamps is not None:
        notes += table_time(tables[inputs.yaw_rate.topic], inputs.yaw_rate.stamp)[1]
    state = State(clock, _first_voltage(inputs, known))
    state, found, own = take(inputs, state, known, changes, rate=axis.rate, effort=axis.effort)
    for settings in thrusters:
        if settings.command == "pwm" and (silent := silent_outputs(settings, state, outputs_alone=True)):
            raise BadInput(without_pulse(settings, silent))
    notes += [*_notes(inputs, axis, clock, known, own, marks), *_change_sentences(changes, clock)]
    if has_unknown_voltage(inputs, state):
        notes.append(Assumption(UNKNOWN_VOLTAGE))
    armed = _armed(inputs, known, clock, None if state.moved is None else state.moved[0], notes)
    own_names = (axis.rate, *((axis.effort,) if thrusters or inputs.torque is not None else ()))
    streams = {**dict.fromkeys(own_names, NONE), **found}
    rising = {name: _rising(mapped.t, mapped.value) for name, mapped in streams.items()}
    there = {name: each for name, each in rising.items() if each[0].size or name in own_names}
    return MeasuredStreams(there, armed, tuple(dict.fromkeys((*doubts, *notes))), doubts)


def _refuse_missing(places: Sequence[Place], tables: Mapping[str, Table]) -> None:
    """Raises BadInput where a topic or a field of the mapping is not there; outputs without a pulse are named later."""
    for place in places:
        an_output = place.name.startswith("thrusters.each") and output(place.topic, place.field) is not None
        if an_output or place.name == "armed":
            continue
        if place.topic not in tables:
            if place.name == "thrusters.measured_voltage":
                continue
            raise BadInput(f"there is no topic {place.topic}; `incsvr inspect FILE` lists all")
        columns = tables[place.topic].columns
        missing = [path for path in (place.field, place.stamp) if path not in (*columns, ARRIVAL)]
        if missing and (missing[0] or not place.field):
            known = ", ".join(list(columns)[:12])
            raise BadInput(
                f"there is no number {missing[0]} in {place.topic}, but {known}; `incsvr inspect FILE` lists them all"
            )


def _with_whole_stamps(places: Sequence[Place], tables: Mapping[str, Table]) -> dict[str, Table]:
    """The tables with stamps as all of them show them: those that go on, without those that nobody set."""
    found = dict(tables)
    stamps = ((place.topic, place.stamp, place.stamp_unit) for place in places)
    for topic, stamp, unit in dict.fromkeys(stamps):
        table = tables.get(topic)
        if table is None or stamp not in table.columns:
            continue
        if table.arrival is None:
            time, _ = table_time(table, stamp)
        else:
            time = table.columns[stamp]
            time = np.where(np.isnan(without_unset(time * STAMP_UNITS[unit])), np.nan, time)
        known = time[np.isfinite(time)]
        if known.size > 1 and not np.ptp(known) and table.arrival is None:
            raise BadInput(
                f"the time {stamp!r} is {known[0]:g} in every row, as where an export cut its digits; export it with "
                "all of them"
            )
        if known.size > 1 and not np.ptp(known):  # nobody set them
            time = np.full(time.size, np.nan)
        elif known.size and table.arrival is not None and table.arrival.size > 1 and not np.ptp(table.arrival):
            found[topic] = replace(found[topic], arrival=None)
        found[topic] = replace(found[topic], columns={**found[topic].columns, stamp: time})
    return found


def _first_voltage(inputs: Inputs, tables: Mapping[str, Table]) -> dict[FieldPlace, Values]:
    """The battery's first voltage [V], which holds before it was told."""
    battery = battery_of(inputs)
    rows = NONE if battery is None else real_values(battery, inputs, tables).rows(slice(1))
    place = () if battery is None or not rows.order.size else ((battery.topic, battery.field),)
    return dict.fromkeys(place, replace(rows, order=np.full(rows.order.size, -np.inf)))


def _without_marks(sources: Mapping[str, Source], tables: dict[str, Table]) -> tuple[dict[str, Table], dict[str, str]]:
    """The tables without a sensor's marks of no measurement, and the notes on these by stream."""
    found, notes = dict(tables), dict[str, str]()
    for name, source in sources.items():
        values, note = without_marks(name, tables[source.topic].columns[source.field], name in EFFORTS)
        if note is not None:
            notes[name] = note
            table = found[source.topic]
            found[source.topic] = replace(table, columns={**table.columns, source.field: values})
    return found, notes


def _notes(
    inputs: Inputs,
    axis: Axis,
    clock: Clock,
    tables: Mapping[str, Table],
    own: Mapping[tuple[str, str], bool],
    marks: Mapping[str, str],
) -> Iterator[str]:
    """Sentences on the marks and the stamps of each stream.

    Args:
        own: by stream and topic, whether its own stamps count.

    Raises:
        BadInput: the stamps are of a simulator whose clock the yaw rate does not bear.
    """
    for (name, topic), is_own in own.items():
        yield from (note for marked, note in marks.items() if marked == name)
        source = inputs.sources_of(axis.rate, axis.effort).get(name, inputs.thrusters)
        stamps = None if source is None else stamps_of(source, tables[topic])
        timed = stamps is not None and tables[topic].arrival is not None
        unset = int(np.isnan(stamps).sum()) if stamps is not None and timed else 0
        if unset and is_own:
            count = tables[topic].count
            yield f"{unset} of {count} messages of {topic} have no stamp: their times of arrival are used"
        if clock.pace != 1.0 and not is_own:
            yield pace_note(axis.rate, clock.pace)
        if stamps is not None and not is_own:
            if (
                name == axis.effort
                and clock.pace == 1.0
                and (found := pace(arrival_of(tables[topic], stamps), stamps)) != 1.0
            ):
                bears = "bears no stamp" if clock.of_arrival else "bears the stamps of the arrivals"
                raise BadInput(
                    f"{axis.rate} {bears}, and those of {name} run at {found:.3g} times the speed of the arrivals, as "
                    f"a simulator's do: record the {words_of(axis).rate} with stamps of that clock"
                )
            yield f"the stamps of {name} are of another clock than those of {axis.rate}: its times of arrival are used"


def _two_senders(inputs: Inputs, tables: Mapping[str, Table], axis: Axis) -> Iterator[str]:
    """Sentences on a yaw rate, a torque or commands that two senders send, by their values or their clocks."""
    named = ((axis.rate, inputs.yaw_rate), (axis.effort, inputs.torque))
    places: list[tuple[str, Source | Thrusters, str, str]] = [
        (n, s, s.topic, s.field) for n, s in named if s is not None
    ]
    if inputs.thrusters is not None:
        of_each = zip(inputs.thrusters.each, inputs.thrusters.topics, strict=True)
        places += [("a thruster's command", inputs.thrusters, topic, each.field) for each, topic in of_each]
    for name, source, topic, path in places:
        table = tables[topic]
        if path not in table.columns:
            continue
        stamps, values = stamps_of(source, table), table.columns[path]
        share = by_turns(table.columns[SENDER], values) if SENDER in table.columns else None
        by_sender = share is not None
        if share is None:
            in_order = _rising(arrival_of(table, stamps) if stamps is None else stamps, values)[1]
            share = alternates(in_order, is_velocity=name == axis.rate)
        if share is not None:
            yield sentence(name, "one name" if topic == ROWS else topic, share, by_sender)
        if table.arrival is not None and stamps is not None and two_clocks(table.arrival, stamps):
            yield (
                f"the stamps of {topic} are of two clocks by turns: two senders send {name} under one name; let one of "
                "them be silent, or give it a name of its own, and record again"
            )


def _rising(time: Array, values: Array) -> Stream:
    """Sorts by stamps, keeps each once, and drops values that were not sampled."""
    kept = np.isfinite(values) & np.isfinite(time)
    time, values = time[kept], values[kept]
    if (np.diff(time) > 0.0).all():
        return time, values
    order = np.argsort(time, kind="stable")
    unique, first = np.unique(time[order], return_index=True)
    return unique, values[order][first]


def _change_sentences(changes: Sequence[Change], clock: Clock) -> tuple[str, ...]:
    """The sentence on parameters that changed during the log."""
    said = []
    for change in changes:
        if change.parameters:
            at = float(clock.times_of(np.array([change.since]), None)[0][0])
            lost = " (the thrusters are not known then, and nothing is learned)" if change.thrusters is None else ""
            said.append(f"{', '.join(change.parameters)} from {at:.6g} s on{lost}")
    more = [f"and {len(said) - MAX_CHANGES_NAMED} more"] if len(said) > MAX_CHANGES_NAMED else []
    return changes_note([*said[:MAX_CHANGES_NAMED], *more])


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
    stamps = stamps_of(settings, table)
    time, _ = clock.times_of(arrival_of(table, stamps), stamps)
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
