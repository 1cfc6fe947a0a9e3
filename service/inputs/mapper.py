"""The one mapper: tables of messages become streams in SI units on one clock, and a state that the next call takes.

A log gives all its messages at once, a bus those of some milliseconds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from service.inputs.clocks import Clock
from service.inputs.live_clock import RATE, LiveClock
from service.inputs.outputs import Ends, first_movement, least_movement, output
from service.inputs.proposal import Change
from service.inputs.settings import ARRIVAL, Armed, Axis, Inputs, Source, Thrusters
from service.inputs.table import MESSAGE, Table
from service.inputs.thrust import T200_NOMINAL_V, efforts, is_battery_voltage, is_pulse
from service.inputs.units import STAMP_UNITS
from service.inputs.values import Values

TORQUE, VOLTAGE, SURGE = "torque", "voltage", "surge"
FieldPlace = tuple[str, str]
"""Topic and path of a number."""
MAX_KEPT = 100
"""Values that are kept for a command which is on its way, where commands come on several topics."""


NONE = Values.of(np.empty(0), np.empty(0))


@dataclass(frozen=True, slots=True)
class State:
    """What messages leave behind for those that come later.

    Attributes:
        clock: the one on which all streams are placed.
        latest: the newest values of what commands are read with, in SI units: those since the newest command.
        commands: the newest of each command; of a log none.
        pulsed: the commands that have borne a pulse; those in another unit that have come.
        ends: the least and the greatest of each command, by the places of all.
        moved: when the commands first moved [s], and its place in the order; None before.
    """

    clock: Clock | LiveClock = field(default_factory=LiveClock)
    latest: Mapping[FieldPlace, Values] = field(default_factory=dict)
    commands: Mapping[FieldPlace, Values] = field(default_factory=dict)
    pulsed: frozenset[FieldPlace] = frozenset()
    ends: Mapping[tuple[FieldPlace, ...], Ends | None] = field(default_factory=dict)
    moved: tuple[float, float] | None = None


def take(
    inputs: Inputs,
    state: State,
    tables: Mapping[str, Table],
    changes: Sequence[Change] = (),
    further: tuple[Axis, ...] = (),
    rate: str = RATE,
    effort: str = TORQUE,
) -> tuple[State, dict[str, Values], Mapping[FieldPlace, bool]]:
    """The streams of the messages, by name, and by stream and topic whether their own stamps count.

    Args:
        inputs: the mapping, with topics and paths as they are in the tables.
        changes: of the thrusters under way.
        further: axes along or about which the thrusters push as well.
        rate, effort: the names of the streams of the velocity and the effort that are learned from.
    """
    call = _Call(inputs, state, tables)
    found = {}
    for name, source in inputs.sources_of(rate, effort).items():
        stream = call.stream(name, source, source.topic, source.field, source.factor)
        if stream.t.size:
            unplaced = np.isnan(stream.t)
            found[name] = stream.rows(~unplaced) if name != rate and unplaced.any() else stream
    if inputs.torque is not None and effort in found:
        rising = found[effort].rows(np.argsort(found[effort].t, kind="stable"))
        call.move(rising, [rising.value], 0.0, [(inputs.torque.topic, inputs.torque.field)])
    until = [*(change.since for change in changes), np.inf]
    made = [
        call.efforts(part.thrusters, part.since, end, (part.thrusters.axis, *further))
        for part, end in zip((Change(-np.inf, inputs.thrusters, ()), *changes), until, strict=True)
        if part.thrusters is not None
    ]
    for name in dict.fromkeys(name for each in made for name in each):
        joined = Values.joined([each[name] for each in made if name in each])
        found[name] = joined.rows(np.argsort(joined.order, kind="stable"))
    return call.ended(), found, call.own


def stamps_of(source: Source | Thrusters | Armed, table: Table) -> Array | None:
    """The stamps (n,) of a table by its own clock [s]; None where the time of arrival counts."""
    if source.stamp in ("", ARRIVAL) or source.stamp not in table.columns:
        return None
    stamps = table.columns[source.stamp] * STAMP_UNITS[source.stamp_unit]
    return stamps if np.isfinite(stamps).any() else None


def arrival_of(table: Table, stamps: Array | None) -> Array:
    """The times of writing (n,) of messages [s], or their stamps if there are no others."""
    arrival = stamps if table.arrival is None else table.arrival
    if arrival is None:
        raise BadInput("no column of the time is known: name it, as in --column t=stamp:ms")
    return arrival


def order_of(table: Table, source: Source | Thrusters) -> Array:
    """The order (n,) in which messages came: their numbers on a bus, their times of writing in a log."""
    return table.columns[MESSAGE] if MESSAGE in table.columns else arrival_of(table, stamps_of(source, table))


def read_with(inputs: Inputs) -> Iterator[Source]:
    """The sources that commands are read with: the voltage, the speed and the angles of the thrusters."""
    if inputs.thrusters is not None:
        named = (battery_of(inputs), inputs.channels.get(SURGE), *(each.turned_by for each in inputs.thrusters.each))
        yield from (source for source in named if source is not None)


def battery_of(inputs: Inputs) -> Source | None:
    """The source of the voltage of the thrusters' battery."""
    own = None if inputs.thrusters is None else inputs.thrusters.measured_voltage
    return own or inputs.channels.get(VOLTAGE)


def silent_outputs(settings: Thrusters, state: State, outputs_alone: bool = False) -> list[int]:
    """The thrusters whose commands have borne no pulse so far, or no other number; of an autopilot's outputs alone."""
    silent = [k for k, place in enumerate(settings.fields) if place not in state.pulsed]
    return [k for k in silent if not outputs_alone or output(*settings.fields[k]) is not None]


def has_unknown_voltage(inputs: Inputs, state: State) -> bool:
    """Whether the thrust of a battery's commands is that of a voltage that nobody sent."""
    settings, source = inputs.thrusters, battery_of(inputs)
    if settings is None or settings.voltage is not None or settings.curve != "t200":
        return False
    known = source is not None and (source.topic, source.field) in state.latest
    return settings.command in ("pwm", "fraction") and not known


def real_values(source: Source, inputs: Inputs, tables: Mapping[str, Table]) -> Values:
    """The values of a source that are numbers, of a battery those that one can have, without times of their own."""
    table = tables.get(source.topic)
    if table is None or source.field not in table.columns:
        return NONE
    values, order = table.columns[source.field] * source.factor, order_of(table, source)
    real = is_battery_voltage(values) if source == battery_of(inputs) else np.isfinite(values)
    return Values.of(order, values, order).rows(real)


class _Call:
    """One call of the mapper.

    Attributes:
        state: after the messages that were mapped.
        own: by stream and topic, whether their own stamps count.
    """

    def __init__(self, inputs: Inputs, state: State, tables: Mapping[str, Table]) -> None:
        self.state, self.own = state, dict[tuple[str, str], bool]()
        self._inputs, self._tables, self._pulsed = inputs, tables, state.pulsed
        self._placed: dict[tuple[str, str], tuple[Array, bool]] = {}

    def stream(self, name: str, source: Source | Thrusters, topic: str, path: str, factor: float = 1.0) -> Values:
        """The numbers of a topic with their times, those of all numbers of a topic alike; none where it has none."""
        table, clock = self._tables.get(topic), self.state.clock
        if table is None or path not in table.columns:
            return NONE
        order, stamps = order_of(table, source), stamps_of(source, table)
        if (topic, source.stamp) not in self._placed:
            arrival = arrival_of(table, stamps)
            if isinstance(clock, Clock):
                ours = isinstance(source, Source) and source.form == "incsvr"
                time, own = clock.times_of(arrival, stamps, ours)
            else:
                clock, time, own = clock.take(name, order, arrival, stamps)
                self.state = replace(self.state, clock=clock)
            self._placed[topic, source.stamp] = time, own
        time, self.own[name, topic] = self._placed[topic, source.stamp]
        values = table.columns[path]
        return Values.of(time, values if factor == 1.0 else values * factor, order)

    def move(self, rows: Values, commands: Sequence[Array], least: float, places: Sequence[FieldPlace]) -> None:
        """Looks at commands (n,) at these rows: how far they have gone, and when they first move."""
        if self.state.moved is None:
            row, ends = first_movement(commands, least, self.state.ends.get(tuple(places)))
            moved = None if row is None else (float(rows.t[row]), float(rows.order[row]))
            self.state = replace(self.state, ends={**self.state.ends, tuple(places): ends}, moved=moved)

    def efforts(self, settings: Thrusters, since: float, until: float, axes: Sequence[Axis]) -> dict[str, Values]:
        """The moments and forces of thrusters as they are within arrivals [s], where each has a command."""
        came = [self._commands(settings, *place) for place in settings.fields]
        rows, commands = join_commands(came, [self.state.commands.get(place, NONE) for place in settings.fields])
        inside = (rows.order >= since) & (rows.order < until)
        rows, commands = rows.rows(inside), [command[inside] for command in commands]
        by_place = {place: each for place, each in zip(settings.fields, came, strict=True) if each.t.size}
        sent = {place for place, each in by_place.items() if np.isfinite(each.value).any()}
        newest = {place: each.rows(np.array([-1])) for place, each in by_place.items()}
        several = isinstance(self.state.clock, LiveClock) and len(set(settings.topics)) > 1
        kept = {**self.state.commands, **newest} if several else {}
        self.state = replace(self.state, pulsed=self.state.pulsed | sent, commands=kept)
        self.move(rows, commands, least_movement(settings), settings.fields)
        return self._made(settings, rows, commands, axes) if rows.t.size else {}

    def _commands(self, settings: Thrusters, topic: str, path: str) -> Values:
        """The commands of a thruster, from its first pulse on."""
        found = self.stream(TORQUE, settings, topic, path)
        if settings.command == "pwm" and (topic, path) not in self._pulsed:
            return replace(found, value=np.where(np.maximum.accumulate(is_pulse(found.value)), found.value, np.nan))
        return found

    def _made(
        self, settings: Thrusters, rows: Values, commands: Sequence[Array], axes: Sequence[Axis]
    ) -> dict[str, Values]:
        """The moments and forces of commands (n,) at these rows, where each command and each angle is known."""
        volts = self._newest(battery_of(self._inputs), rows.order)
        usual = T200_NOMINAL_V if settings.voltage is None else settings.voltage
        speed = np.nan_to_num(self._newest(self._inputs.channels.get(SURGE), rows.order))
        turned = ((k, each.turned_by) for k, each in enumerate(settings.each))
        angles = {k: self._newest(angle, rows.order) for k, angle in turned if angle is not None}
        with np.errstate(all="ignore"):  # what is no command makes no moment, and is refused as beyond the plausible
            totals = efforts(settings, axes, commands, np.where(np.isnan(volts), usual, volts), speed, angles)
        known = np.ones(rows.t.size, dtype=bool)
        for each in (*commands, *angles.values()):
            known &= ~np.isnan(each)
        names = (TORQUE, *(AXES[axis].effort for axis in axes[1:]))
        return {name: replace(rows, value=total).rows(known) for name, total in zip(names, totals, strict=True)}

    def _newest(self, source: Source | None, order: Array) -> Array:
        """The newest value of a source when commands came (n,); NaN where none had come."""
        rows = NONE if source is None else self._read_with(source)
        if not rows.order.size:
            return np.full(order.size, np.nan)
        rows = rows.rows(np.argsort(rows.order, kind="stable"))
        place = np.searchsorted(rows.order, order, side="right") - 1
        return np.where(place >= 0, rows.value[np.maximum(place, 0)], np.nan)

    def _read_with(self, source: Source) -> Values:
        """The values of a source, those that came before among them."""
        before = self.state.latest.get((source.topic, source.field), NONE)
        return Values.joined([before, real_values(source, self._inputs, self._tables)])

    def ended(self) -> State:
        """The state for the next call, which may hold commands that came after the newest of each here."""
        latest = dict[FieldPlace, Values]()
        since = min((each.order[-1] for each in self.state.commands.values()), default=np.inf)
        for source in read_with(self._inputs):
            rows = self._read_with(source)
            first = max(np.searchsorted(rows.order, since, side="right") - 1, rows.order.size - MAX_KEPT, 0)
            latest |= {(source.topic, source.field): rows.rows(np.arange(first, rows.order.size))}
        kept = {place: each for place, each in latest.items() if each.order.size}
        return replace(self.state, latest={**self.state.latest, **kept})


def join_commands(streams: Sequence[Values], before: Sequence[Values]) -> tuple[Values, list[Array]]:
    """The commands of all thrusters, at each stamp of one of them.

    Args:
        before: the newest command of each that came before.

    Returns:
        The stamps (n,) [s], each once, and the order of the last command of each; the command of each thruster at that
        time, (n,) each, NaN before its first.
    """
    first = streams[0]
    rising = (np.diff(first.t) > 0.0).all() and np.isfinite(first.t).all()
    if rising and all(stream.t is first.t for stream in streams):
        return first, [stream.value for stream in streams]
    time = np.unique(np.concatenate([stream.t for stream in streams]))
    time = time[np.isfinite(time)]
    order = np.full(time.size, -np.inf)
    commands = []
    for stream in map(Values.joined, zip(before, streams, strict=True)):
        if not stream.t.size:
            commands.append(np.full(time.size, np.nan))
            continue
        by_stamp = np.argsort(stream.t, kind="stable")
        place = np.searchsorted(stream.t[by_stamp], time, side="right") - 1
        newest = by_stamp[np.maximum(place, 0)]
        commands.append(np.where(place >= 0, stream.value[newest], np.nan))
        own = (place >= 0) & (stream.t[newest] == time)
        order[own] = np.maximum(order[own], stream.order[newest[own]])
    return Values.of(time, order, order), commands
