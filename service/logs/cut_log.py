"""The part of a log between two instants: its topics and their messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.numerics import Array
from service.inputs.measured_streams import MeasuredStreams
from service.inputs.settings import Inputs
from service.inputs.table import Table, Topic
from service.logs.cutting import Cut, Span, columns_inside, rows_inside
from service.logs.reading import writing_times


def cut_log(
    topics: Sequence[Topic],
    tables: Mapping[str, Table],
    inputs: Inputs,
    measured: MeasuredStreams | None,
    cut: Cut,
    since_1970: float | None,
) -> tuple[tuple[Topic, ...], dict[str, Table], MeasuredStreams | None]:
    """Topics, messages and measurements that a cut holds. Messages are cut by the time at which they were written.

    What says whether the vehicle was armed is kept whole: it holds on from before the cut.

    Args:
        measured: of the whole log; None where no yaw rate was found.
        since_1970: what makes seconds since 1970 of the stamps of the measurements [s]; None where nothing says it.

    Raises:
        NothingHeld: it holds nothing.
        BadInput: it is a time of day, and nothing says it.
    """
    written = {name: writing_times(table, inputs) for name, table in tables.items()}
    known = [time[np.isfinite(time)] for time in written.values()]
    every = np.concatenate([*known, np.empty(0)])
    shift = 0.0
    if measured is not None and measured.streams["yaw_rate"][0].size and inputs.yaw_rate is not None:
        stamps = measured.streams["yaw_rate"][0]
        span = Span(float(stamps[0]), float(stamps[-1]), since_1970)
        arrival = written[inputs.yaw_rate.topic]
        shift = float(np.median(arrival[np.isfinite(arrival)]) - np.median(stamps)) if arrival.size else 0.0
    elif every.size:
        span = Span(float(every.min()), float(every.max()))
    else:
        return tuple(topics), dict(tables), measured
    placed = cut.in_stamps(span)
    if measured is not None:
        rows_inside(measured.streams["yaw_rate"][0], cut, span)
        streams = {name: _between(time, values, placed, span) for name, (time, values) in measured.streams.items()}
        measured = replace(measured, streams={name: each for name, each in streams.items() if each[0].size})
    low, high = placed.ends(span)
    inside = {name: (time >= low + shift) & (time <= high + shift) for name, time in written.items() if time.size}
    cut_tables = {name: _rows(table, inside[name]) for name, table in tables.items() if name in inside}
    counts = {name: int(np.count_nonzero(rows)) for name, rows in inside.items()}
    cut_topics = tuple(replace(topic, count=counts.get(topic.name, topic.count)) for topic in topics)
    return cut_topics, {**tables, **cut_tables}, measured


def _between(time: Array, values: Array, cut: Cut, span: Span) -> tuple[Array, Array]:
    low, high = cut.ends(span)
    inside = (time >= low) & (time <= high)
    return time[inside], values[inside]


def _rows(table: Table, inside: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Table:
    places = np.flatnonzero(inside)
    texts = {name: tuple(each[k] for k in places) for name, each in table.texts.items()}
    arrival = None if table.arrival is None else table.arrival[inside]
    return Table(arrival, columns_inside(table.columns, inside), texts)
