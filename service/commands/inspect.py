"""`incsvr inspect`: what is in a log of any format, how often, in which range, and what of it would be learned from.

With `--bus` the same of a vehicle's bus (`service.commands.inspect_bus`).
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, YAW
from incsvr.plant.words import words_of
from incsvr.signals.message_rates import slow_torque
from service.cli.extras import plots
from service.cli.next_command import LOG_FLAGS, following, with_next
from service.cli.output import WIDTH, add_json_argument, emit, shortened, wrapped
from service.cli.progress import progress
from service.config.sources import add_client_arguments, from_arguments
from service.inputs.arming import arming_spans, is_within
from service.inputs.clocks import without_leaps
from service.inputs.measured_streams import MeasuredStreams
from service.inputs.proposal import Proposal
from service.inputs.settings import Inputs, Source, Thrusters
from service.inputs.table import Table, Topic
from service.inputs.units import si_unit, units_of
from service.logs.candidates import in_degrees, refuse_without_numbers
from service.logs.cutting import Cut
from service.logs.dives import one_dive
from service.logs.reading import LogDescription, cut_log, describe, read, writing_times
from service.recordings.reading import add_log_arguments

BUS = "service.commands.inspect_bus"
"""The module that inspects a bus."""
SHOWN_FIELDS = 6
"""Fields of a topic that are shown to people; all of them go into the JSON object."""
STAMP_FIELDS = ("timestamp", "TimeUS", "time_boot_ms", "time_usec", "header.stamp")
"""Fields whose range nobody looks at."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files", nargs="*", type=Path, metavar="FILE", help="a log, the folder of a bag, or the files of one dive"
    )
    parser.add_argument("--bus", action="store_true", help="inspect the vehicle's bus instead of a log")
    parser.add_argument(
        "--ask",
        type=float,
        metavar="HZ",
        help="with --bus: first ask a BlueOS vehicle to send attitude and outputs at this rate [Hz]",
    )
    parser.add_argument("--seconds", type=float, default=10.0, help="with --bus: how long to listen [s] (default 10)")
    add_client_arguments(parser, wait_s=3.0, whom=", with --bus, to reach the bus")
    add_log_arguments(parser, axis=False)
    parser.add_argument("--topic", metavar="NAME", help="show all fields of this topic")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw the streams into this file (.png, .svg, .pdf; matplotlib)"
    )
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.bus:
        _refuse_of_log(args)
        return int(import_module(BUS).inspect_bus(args))  # loads Zenoh, which no log needs
    if not args.files:
        raise BadInput("name a log, or inspect the vehicle's bus with --bus")
    if args.ask is not None:
        raise BadInput("--ask asks a vehicle on the bus; add --bus and leave out the log")
    inputs = from_arguments(args).inputs
    said = {"preset": args.preset, "system": args.system}
    inputs = inputs.model_copy(update={name: value for name, value in said.items() if value is not None})
    with progress(f"reading {args.files[0].name}"):
        summary = _read(args, LogDescription(tuple(args.column), inputs))
    if args.plot is not None:
        _plot(args.plot, summary)
    after = _next(args, summary)
    emit(args, _result(summary) | {"next": after[0]}, with_next(_text(args, summary), *after))
    return 0


def _refuse_of_log(args: argparse.Namespace) -> None:
    """Refuses, with --bus, what speaks of a log."""
    if args.files:
        raise BadInput(f"{args.files[0]}: inspect either this log or, with --bus, the vehicle's bus")
    of_log = {"topic": args.topic, "plot": args.plot, "column": args.column, "from": args.cut_from, "to": args.cut_to}
    if flag := next((flag for flag, value in of_log.items() if value), None):
        raise BadInput(f"--{flag} is about a log; leave it out with --bus")
    named = {"inputs.preset": args.preset, "inputs.system": args.system}
    if flag := next((name for name, value in named.items() if value), None):
        raise BadInput(f"with --bus write --set {flag}={named[flag]}")


def _next(args: argparse.Namespace, summary: LogSummary) -> tuple[str, str]:
    """The command that follows, and what it does."""
    streams = {} if summary.measured is None else summary.measured.streams
    driven = [axis for axis in AXES.values() if {axis.rate, axis.effort} <= streams.keys()]
    if len(driven) > 1:
        flags = ("--write", "vehicle.yaml")
        return following(args, "identify", args.files, LOG_FLAGS, *flags), "identifies the whole vehicle"
    if driven:
        axis = () if driven == [YAW] else ("--axis", driven[0].name)
        command = following(args, "fit", args.files, LOG_FLAGS, *axis, "--inertia", "estimate")
        return command, f"learns the damping; give the {words_of(driven[0]).inertia} instead if you know it"
    absent = "yaw_rate" if YAW.rate not in streams else "torque"
    command = following(args, "inspect", args.files, LOG_FLAGS, "--column", f"{absent}=COLUMN")
    return command, "with the name of the column that holds it"


def _plot(path: Path, summary: LogSummary) -> None:
    """Draws what would be learned from over time.

    Raises:
        BadInput: nothing would be, matplotlib is missing, or the file cannot be written.
    """
    measured = summary.measured
    if measured is None:
        raise BadInput(f"{summary.name}: --plot needs a yaw rate: name it with --column yaw_rate=FIELD")
    armed = None if measured.armed is None else arming_spans(*measured.armed)
    units = {name: each["unit"] for name, each in _measured(summary.proposal.inputs, measured).items()}
    figure = plots().of_log(summary.name, measured.streams, units, armed)
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: cannot be written ({error}); name a file such as log.png") from None


def _read(args: argparse.Namespace, description: LogDescription) -> LogSummary:
    """The contents of the files, and the streams that would be learned from."""
    dive, cut = one_dive(args.files, description), Cut.of(args)
    log, path = dive.opened(description), dive.path
    if args.topic is not None and args.topic not in {topic.name for topic in log.topics}:
        raise BadInput(f"{path}: there is no topic {args.topic}; `incsvr inspect {path}` lists them all")
    proposal = describe(log, description)
    measured = None
    if proposal.inputs.yaw_rate is not None and "t" not in proposal.missing:
        try:
            measured = read(path, log, replace(proposal, missing={}))
        except BadInput as error:
            proposal = replace(proposal, missing={**proposal.missing, "reading": str(error)})
    refuse_without_numbers(path, log)
    tables = log.read([topic.name for topic in log.topics])
    topics = log.topics
    if cut:
        try:
            topics, tables, measured = cut_log(topics, tables, proposal.inputs, measured, cut)
        except BadInput as error:
            raise type(error)(f"{path}: {error}") from None
    if measured is not None and {"yaw_rate", "torque"} <= set(measured.streams):
        slow = slow_torque(measured.streams["yaw_rate"], measured.streams["torque"])
        measured = (
            measured
            if slow is None
            else replace(measured, notes=(*measured.notes, slow.of_a_log_by(proposal.inputs.preset)))
        )
    looks = {} if measured is None else in_degrees(proposal.inputs, measured.streams)
    proposal = replace(proposal, notes=(*looks.values(), *dive.notes, *proposal.notes))
    return LogSummary(
        dive.name,
        log.format,
        _streams(topics, tables, proposal.inputs),
        proposal,
        measured,
        frozenset(n for n in looks if ":deg" in looks[n]),
    )


@dataclass(frozen=True, slots=True)
class LogSummary:
    """The summary of a log that `inspect` shows: name, format, streams, and those that would be learned from.

    Attributes:
        streams: each topic as the contract tells it: its messages a second, how long it went on [s], and the ranges of
            its fields.
        degrees: the quantities that look as if they were in degrees.
    """

    name: str
    format: str
    streams: list[dict[str, Any]]
    proposal: Proposal
    measured: MeasuredStreams | None
    degrees: frozenset[str]


def _streams(topics: tuple[Topic, ...], tables: Mapping[str, Table], inputs: Inputs) -> list[dict[str, Any]]:
    found = []
    for topic in topics:
        table = tables.get(topic.name)
        columns = {} if table is None else table.columns
        ends = {name: _range(values) for name, values in columns.items()}
        span, rate = (0.0, 0.0) if table is None else _pace(writing_times(table, inputs))
        found.append(
            {
                "name": topic.name,
                "type": topic.type,
                "fields": list(dict.fromkeys((*topic.fields, *columns))),
                "count": topic.count,
                "rate_hz": rate,
                "span_s": span,
                "ranges": {name: list(each) for name, each in ends.items() if np.isfinite(each).all()},
            }
        )
    return found


def _pace(time: Array) -> tuple[float, float]:
    known = without_leaps(np.unique(time[np.isfinite(time)]))[0]
    span = float(np.ptp(known)) if known.size else 0.0
    if known.size < 3:
        return span, 0.0  # two messages have no rate
    return span, (np.count_nonzero(np.isfinite(time)) - 1) / span


def _range(values: Array) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)


def _result(summary: LogSummary) -> dict[str, Any]:
    """The contract's form, and what explains it."""
    proposal, measured = summary.proposal, summary.measured
    inputs = proposal.inputs.model_dump(mode="json", exclude_defaults=True)
    return {
        "format": summary.format,
        "streams": summary.streams,
        "armed": None if measured is None else _armed(measured),
        "proposal": inputs | {"notes": list(proposal.sentences), "missing": dict(proposal.missing)},
        "measured": _measured(proposal.inputs, measured),
    }


def _measured(inputs: Inputs, measured: MeasuredStreams | None) -> dict[str, Any]:
    """Each measured stream as it is used, with its unit."""
    found = {}
    for name, stream in () if measured is None else measured.streams.items():
        source = {"yaw_rate": inputs.yaw_rate, "torque": inputs.torque, **inputs.channels}.get(name)
        found[name] = _summary(*stream) | {"unit": si_unit(name) if source is None else units_of(name, source)[1]}
    return found


def _armed(measured: MeasuredStreams) -> dict[str, Any] | None:
    """Whether the vehicle was ever armed, and for how long while the yaw rate was measured [s]."""
    if measured.armed is None:
        return None
    time = measured.streams["yaw_rate"][0]
    inside = arming_spans(*measured.armed)
    steps = np.diff(time, append=time[-1:])
    return {"ever": bool(inside), "seconds": float(steps[is_within(time, inside)].sum()) if inside else 0.0}


def _summary(time: Array, values: Array) -> dict[str, Any]:
    span, rate = _pace(time)
    low, high = _range(values)
    return {"count": int(time.size), "rate_hz": rate, "span_s": span, "low": low, "high": high}


def _text(args: argparse.Namespace, summary: LogSummary) -> str:
    """The summary for people, in 80 columns."""
    streams = summary.streams
    lines = [f"{summary.name}: {summary.format}, {len(streams)} topic{'' if len(streams) == 1 else 's'}", ""]
    if args.topic is not None:
        return "\n".join([lines[0], *_fields(next(each for each in streams if each["name"] == args.topic))])
    widest = min(max((len(each["name"]) for each in streams), default=0), 34)
    lines.append(f"{'topic':<{widest}}  messages       Hz  fields")
    for each in streams:
        fields = [name for name in each["fields"] if name not in STAMP_FIELDS]
        more = f" … {len(fields)}" if len(fields) > SHOWN_FIELDS else ""
        shown = ", ".join(fields[:SHOWN_FIELDS]) or "(not read here)"
        room = WIDTH - widest - 21 - len(more)
        shown = shown if len(shown) <= room else f"{shown[: room - 1]}…"
        name = shortened(each["name"], widest)
        lines.append(f"{name:<{widest}}  {each['count']:8d}  {each['rate_hz']:7.4g}  {shown}{more}")
    return "\n".join([*lines, "", *_proposed(summary)])


def _fields(stream: Mapping[str, Any]) -> list[str]:
    lines = [f"{stream['name']}: {stream['count']} messages, {stream['rate_hz']:.4g} Hz, {stream['span_s']:.4g} s"]
    for name in stream["fields"]:
        low, high = stream["ranges"].get(name, (np.nan, np.nan))
        lines.append(f"  {name:<40} {low:14.6g} {high:14.6g}")
    return lines


def _proposed(summary: LogSummary) -> list[str]:
    proposal, measured = summary.proposal, summary.measured
    inputs = proposal.inputs
    preset = f" (preset {inputs.preset})" if inputs.preset else ""
    lines = [f"what would be learned from{preset}:"]
    named: list[tuple[str, Source | Thrusters | None]] = [
        ("yaw_rate", inputs.yaw_rate),
        ("torque", inputs.torque or inputs.thrusters),
        *inputs.channels.items(),
    ]
    for name, source in named:
        lines += _lines(name, source, summary)
    lines += wrapped("  missing: ", proposal.missing.values())
    armed = None if measured is None else _armed(measured)
    if measured is not None:
        said = "not in the log" if armed is None else "never armed: nothing to learn from"
        if armed is not None and armed["ever"]:
            said = f"armed for {armed['seconds']:.4g} s"
        lines.append(f"  armed: {said}")
    return lines + wrapped("  note: ", (*proposal.sentences, *(measured.notes if measured else ())))


def _lines(name: str, source: Source | Thrusters | None, summary: LogSummary) -> list[str]:
    """One quantity: the numbers that the log holds in the log's unit; where a factor changes them, what is used."""
    if source is None:
        return [f"  {name:<11} nothing"]
    measured = _measured(summary.proposal.inputs, summary.measured).get(name)
    if isinstance(source, Source):
        where, unit, factor = f"{source.topic}.{source.field}", units_of(name, source)[0], source.factor
        ranges = {each["name"]: each["ranges"] for each in summary.streams}
        ends = ranges.get(source.topic, {}).get(source.field)
    else:
        where, unit, factor = f"thrusters of {source.topics[0]}", si_unit(name), 1.0
        ends = None if measured is None else (measured["low"], measured["high"])
    mark = "degrees?" if name in summary.degrees else ""
    unit = f" [{': '.join(each for each in (unit, mark) if each)}]" if unit or mark else ""
    figures = "" if measured is None or ends is None else f"{measured['rate_hz']:.3g} Hz, {_span(*ends)}"
    where = shortened(where, WIDTH - 14 - len(figures) - len(unit) - 2)
    lines = [f"  {name:<11} {where}{unit}  {figures}".rstrip()]
    if measured is not None and factor != 1.0:
        used = f"{_span(measured['low'], measured['high'])} {measured['unit']}".rstrip()
        lines.append(f"{'':14}× {factor:.5g} = {used}")
    return lines


def _span(low: float, high: float) -> str:
    return f"{low + 0.0:.5g} to {high + 0.0:.5g}"  # -0.0 + 0.0 is 0.0
