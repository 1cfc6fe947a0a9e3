"""The measurements of a log as a recording of what may be learned from, or why there is none."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from incsvr.signals.steps import refuse_steps
from service.inputs.arming import Spans, arming_spans, is_within
from service.inputs.clocks import without_leaps
from service.inputs.column_spec import typed_source, typed_source_with_unit
from service.inputs.measured_streams import MeasuredStreams
from service.inputs.proposal import Proposal
from service.inputs.settings import Inputs, Source
from service.inputs.table import ROWS
from service.inputs.units import SI_UNITS, units_of
from service.logs import Log
from service.logs.candidates import likely_scale, turning_instead
from service.logs.csv_log import OURS
from service.logs.cutting import ARMED_CHANNEL, Cut, Span, refuse_empty, streams_inside
from service.recordings.log_refusals import refuse_fraction, refuse_still, refuse_whole_numbers
from service.recordings.recording import Recording, ends_of
from service.recordings.velocities import in_body

if TYPE_CHECKING:
    from service.recordings.reading import Reading

NEVER_ARMED = "never armed, so there is nothing to learn from: give a log of a dive in which the thrusters were armed"


def recording_of(reading: Reading, path: Path, log: Log, proposal: Proposal, measured: MeasuredStreams) -> Recording:
    """The measurements of a log as a recording, or why they are none."""
    ours, source = log.format == OURS, proposal.inputs.yaw_rate
    if reading.learns and measured.doubts:
        raise BadInput(f"{path}: {measured.doubts[0]}")
    of_yaw = source if reading.axis == YAW else None
    if of_yaw is not None and not measured.streams[YAW.rate][0].size:
        instead = turning_instead(log, of_yaw, YAW.rate)
        if instead or not ours:
            cure = instead or f"; `incsvr inspect {path}` shows what there is"
            raise BadInput(f"{path}: there is no value of yaw_rate in {of_yaw.topic}{cure}")
    recording = _in_cut(reading, path, log, measured, proposal.inputs)
    notes, places = (*proposal.sentences, *measured.notes), _places(proposal.inputs, reading.axis, ours)
    units = {name: units_of(name, source)[1] for name, source in proposal.inputs.channels.items() if source.unit}
    recording = replace(recording, axis=reading.axis, notes=notes, places=places, units=units)
    recording = in_body(recording, reading.description.inputs)
    refuse_fraction(path, proposal.inputs, measured, words_of(reading.axis))
    if not reading.learns:
        return recording
    recording = armed_alone(path, recording, ours and reading.ours_whole)
    if ours and (of_yaw is None or not turning_instead(log, of_yaw, YAW.rate)):
        return recording
    refuse_still(path, log, of_yaw, recording.rate, words_of(reading.axis))
    return recording


def _in_cut(reading: Reading, path: Path, log: Log, measured: MeasuredStreams, inputs: Inputs) -> Recording:
    """The streams in the cut as they are, with a channel that says when the vehicle was armed, if anything does.

    Of our own recordings that is their own channel, and all stand in the order in which they were written.
    """
    axis, ours = reading.axis, log.format == OURS
    for name in (axis.rate, axis.effort):
        if name not in measured.streams or not measured.streams[name][0].size:
            raise BadInput(
                f"{path}: the column {name} is empty; it must hold the {_quantity(axis, name)}"
                if ours
                else f"{path}: there is no value of {name}; `incsvr inspect {path}` shows what there is"
            )
    time = measured.streams[axis.rate][0]
    streams: Streams = _later(measured.streams)
    instants = streams[axis.rate][0]
    shift = float(instants[0] - time[0])
    if measured.armed is not None and ours:
        streams = {**streams, ARMED_CHANNEL: measured.armed}
    elif measured.armed is not None:
        on = is_within(instants - shift, arming_spans(*measured.armed))
        streams = {**streams, ARMED_CHANNEL: (instants, on.astype(np.float64))}
    if ours:
        streams = {name: streams[name] for name in log.topics[0].fields if name in streams}
    for name, (stamps, _) in streams.items():
        refuse_steps(stamps, f"{path}: the times of {name}")
    try:
        since = None if measured.since_1970 is None else measured.since_1970 - shift
        streams = _cut(streams, reading.cut, since)
    except BadInput as error:
        raise type(error)(f"{path}: {error}") from None
    for name in (axis.rate, axis.effort):
        if not streams[name][0].size:
            raise BadInput(f"{path}: there is no value of {name} in the part that {reading.cut} takes")
    recording, source = Recording(path.name, streams, axis=axis), inputs.yaw_rate
    in_si = source is not None and source.scale == 1.0 and source.unit in ("", SI_UNITS[source.unit])
    if source is not None and in_si and (reading.learns or ours):
        refuse_whole_numbers(path, recording.rate, axis, typed_source(source))
    beyond = np.flatnonzero(np.abs(recording.rate) > reading.rate_limit)
    if beyond.size:
        rate, at, unit = recording.rate[beyond[0]], streams[axis.rate][0][beyond[0]], words_of(axis).rate_unit
        row = _row(log, at)
        place = f"{row}: {axis.rate} is {rate:g}" if row else f": {axis.rate} is {rate:g} at {at:.10g} s"
        raise BadInput(
            f"{path}{place}, beyond the plausible ±{reading.rate_limit:g} {unit}{_unit(source, axis, recording.rate)}"
            + (f"; if the vehicle really turns so fast, raise {reading.limit_is}" if reading.limit_is else "")
        )
    return recording


def _row(log: Log, stamp: float) -> str:
    """The row of a stamp [s] in words, where a log is one recording of our own; else nothing."""
    if log.format != OURS:
        return ""
    return f", row {int(np.searchsorted(without_leaps(log.tables[ROWS].columns['t'])[0], stamp)) + 2}"


def _cut(streams: Streams, cut: Cut, since_1970: float | None) -> Streams:
    """The part of streams that a cut holds, with the stamps that they have.

    Args:
        since_1970: what makes seconds since 1970 of their stamps [s]; None where nothing says it.

    Raises:
        EmptyCut: there is nothing in it.
        BadInput: the cut is a time of day, and nothing says it.
    """
    if not cut:
        return streams
    span = Span(*ends_of(streams), since_1970)
    found = streams_inside(streams, *cut.ends(span))
    refuse_empty(cut, np.array([time.size > 0 for time, _ in found.values()]), span)
    return found


def _quantity(axis: Axis, column: str) -> str:
    """The quantity and unit of the velocity or the effort of an axis."""
    words = words_of(axis)
    if column == axis.rate:
        return f"{words.rate} [{words.rate_unit}]"
    return f"{words.name} {words.moment} of the actuators [{words.effort_unit}]"


def _places(inputs: Inputs, axis: Axis, ours: bool) -> dict[str, str]:
    """The sources of all quantities, with their units as a person types them; of `ours` those of another name."""
    sources = inputs.sources_of(axis.rate, axis.effort)
    return {
        name: typed_source_with_unit(source) for name, source in sources.items() if not ours or source.field != name
    }


def _unit(source: Source | None, axis: Axis, rate: Array) -> str:
    """The flag for a yaw rate (n,) in degrees per second, or another unit, that was read as rad/s."""
    if source is None or axis.along or source.unit not in ("", "rad/s"):
        return ""
    scale = likely_scale(axis, float(np.quantile(np.abs(rate), 0.99)))
    place = shlex.quote(f"{axis.rate}={typed_source(source)}{scale}")
    unit = {":deg/s": "degrees per second", ":mrad/s": "milliradians per second"}.get(scale, "another unit")
    return f"; if it is in {unit}, give the unit: --column {place}"


def _later(streams: Streams) -> dict[str, Stream]:
    """The streams on a clock that does not begin before zero."""
    shift = max(0.0, -min(float(time[0]) for time, _ in streams.values() if time.size))
    return {name: (time + shift, values) for name, (time, values) in streams.items()}


def armed_spans(recording: Recording) -> Spans | None:
    """The spans in which the vehicle was armed [s]; None if unknown."""
    if ARMED_CHANNEL not in recording.own_streams:
        return None
    return arming_spans(*recording.own_streams[ARMED_CHANNEL])


def armed_alone(path: Path, recording: Recording, whole: bool = False) -> Recording:
    """The part of a recording while the vehicle was armed; with `whole` all of it, if it was armed at all."""
    wanted = armed_spans(recording)
    if wanted is None:
        return recording
    if not wanted:
        raise BadInput(f"{path}: the vehicle was {NEVER_ARMED}")
    if whole:
        return recording
    streams = dict[str, Stream]()
    for name, (time, values) in recording.own_streams.items():
        inside = is_within(time, wanted)
        streams[name] = time[inside], values[inside]
    streams.pop(ARMED_CHANNEL)
    for name in (recording.axis.rate, recording.axis.effort):
        if not streams[name][0].size:
            raise BadInput(f"{path}: there is no value of {name} while the vehicle was armed; give a longer log")
    notes, (first, last) = recording.notes, recording.span
    if not is_within(recording.time, wanted).all():
        on = sum(min(high, last) - max(low, first) for low, high in wanted)
        notes = (*notes, f"armed for {on:.3g} of {last - first:.3g} s; the rest is left out")
    return replace(recording, own_streams=streams, notes=notes)
