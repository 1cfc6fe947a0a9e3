"""The files that are one dive: those that continue each other in time, and a folder's logs; and these logs as one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import isfinite, nan
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.owners import AUTOPILOT
from service.inputs.settings import Inputs
from service.inputs.table import ROWS, Table, Topic
from service.inputs.vehicles import present_vehicles
from service.logs.choosing import choose_vehicle, with_plain_names
from service.logs.csv_log import OURS
from service.logs.cutting import MIN_STAMP_SINCE_1970_S
from service.logs.log import Log
from service.logs.opening import is_log, open_any
from service.logs.reading import NO_DESCRIPTION, LogDescription, describe, writing_times


def joined_log(parts: Sequence[Log]) -> Log:
    """The parts of a log in the order of time, as one.

    A telemetry log calls the messages of the vehicle that it chose by their plain names. Over several of them the
    choice is made anew, so the plain names are those of the vehicle that is chosen over all parts.
    """
    topics, tables = dict[str, Topic](), dict[str, list[Table]]()
    for part in parts:
        for topic in part.topics:
            name = _in_full(topic)
            before = topics.get(name, Topic(name, topic.type, (), 0))
            fields = tuple(dict.fromkeys((*before.fields, *topic.fields)))
            topics[name] = replace(before, fields=fields, count=before.count + topic.count)
            if topic.name in part.tables:
                tables.setdefault(name, []).append(part.tables[topic.name])
    joined = Log(
        next((part.format for part in parts if part.format != OURS), OURS),
        tuple(topics[name] for name in sorted(topics)),
        {name: _join(found) for name, found in tables.items()},
        tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        tuple(each for part in parts for each in part.broken),
    )
    return with_plain_names(joined) if any(topic.system for part in parts for topic in part.topics) else joined


def refuse_other_vehicles(paths: Sequence[Path], parts: Sequence[Log], joined: Log, inputs: Inputs) -> None:
    """Refuses parts that hold nothing of the vehicle that is taken.

    Raises:
        BadInput: naming the part and whose it is.
    """
    choice = choose_vehicle(joined, inputs)
    if not choice.others:
        return
    for path, part in zip(paths, parts, strict=True):
        here = present_vehicles(part.topics, choice.system)
        if choice.system not in here:
            raise BadInput(
                f"{path}: this part has no data of vehicle {choice.system}, which is used, but of vehicle "
                f"{', '.join(sorted(here))}: parts of one dive are of one vehicle; leave it out"
            )


def _in_full(topic: Topic) -> str:
    """The name of a topic that says whose it is."""
    return f"mavlink/{topic.system}/{AUTOPILOT}/{topic.name}" if topic.system else topic.name


def _join(parts: Sequence[Table]) -> Table:
    """The messages of several tables by their times of arrival."""
    if len(parts) == 1:
        return parts[0]
    counts = [part.count for part in parts]
    columns = {
        name: np.concatenate(
            [part.columns.get(name, np.full(n, np.nan)) for part, n in zip(parts, counts, strict=True)]
        )
        for name in dict.fromkeys(name for part in parts for name in part.columns)
    }
    texts = {
        name: tuple(text for part, n in zip(parts, counts, strict=True) for text in part.texts.get(name, ("",) * n))
        for name in dict.fromkeys(name for part in parts for name in part.texts)
    }
    came: list[Array] = [part.arrival for part in parts if part.arrival is not None]
    if len(came) < len(parts):
        return Table(None, columns, texts, parts[0].instants)
    arrival = np.concatenate(came)
    order = np.argsort(arrival, kind="stable")
    return Table(
        arrival[order],
        {name: values[order] for name, values in columns.items()},
        {name: tuple(values[k] for k in order) for name, values in texts.items()},
    )


MAX_PAUSE_S = 600.0
"""The time between two files that a person names one by one within which they are parts of one dive [s]."""
MAX_OVERLAP_S = 1.0
"""The time by which parts may overlap [s]: a recorder that changes its file writes some messages late."""
DIVE_RULE = (
    "a folder, or files that continue each other within ten minutes, are one dive; other files are separate runs"
)
"""The rule by which files are one dive, for `--help`."""


@dataclass(frozen=True, slots=True)
class Part:
    """A file of a dive.

    Attributes:
        path: of the file.
        log: what is in it; None where nobody had to look.
        first, last: from when to when [s], by the clock of the log; NaN where that is not known.
    """

    path: Path
    log: Log | None = None
    first: float = nan
    last: float = nan

    @property
    def placed(self) -> bool:
        """Whether it is known when it was."""
        return isfinite(self.first)

    @property
    def kind(self) -> tuple[str, bool]:
        """Parts of one dive have one format, and stamps that count from the same time."""
        kind = "" if self.log is None else "CSV" if self.log.format == OURS else self.log.format
        return (kind, self.first >= MIN_STAMP_SINCE_1970_S)


@dataclass(frozen=True, slots=True)
class Dive:
    """One or several files that are one recording.

    Attributes:
        path: the file, or the folder; of several files the first.
        parts: in the order of time.
    """

    path: Path
    parts: tuple[Part, ...]

    @property
    def name(self) -> str:
        """The name for people."""
        more = len(self.parts) - 1
        return self.path.name if self.path.is_dir() or not more else f"{self.path.name} and {more} more"

    @property
    def notes(self) -> tuple[str, ...]:
        """The note that several files are read as one."""
        if len(self.parts) < 2:
            return ()
        return (f"read as one log, in the order of time: {', '.join(part.path.name for part in self.parts)}",)

    def opened(self, description: LogDescription = NO_DESCRIPTION) -> Log:
        """The log of all parts together.

        Raises:
            BadInput: a part cannot be read, or is of another vehicle.
        """
        logs = [open_any(part.path) if part.log is None else part.log for part in self.parts]
        if len(logs) == 1:
            return logs[0]
        joined = joined_log(logs)
        refuse_other_vehicles([part.path for part in self.parts], logs, joined, description.inputs)
        return joined


Opened = Callable[[Path], Log]
"""What opens a file."""


def dives(paths: Sequence[Path], description: LogDescription = NO_DESCRIPTION, opened: Opened = open_any) -> list[Dive]:
    """The dives that files and folders are, in the order in which they were given.

    Raises:
        BadInput: a folder holds no log, logs of several kinds, or logs that overlap in time.
    """
    found: list[Dive] = []
    files: list[Path] = []
    for path in paths:
        if path.is_dir() and not is_log(path):
            found.append(_of_folder(path, description, opened))
        else:
            files.append(path)
    if len(files) == 1:
        found.append(Dive(files[0], (Part(files[0]),)))
    elif files:
        found += _dives_of_files([_part(path, description, opened) for path in files])
    return sorted(found, key=lambda dive: min(_place(paths, dive.path), *(_place(paths, p.path) for p in dive.parts)))


def one_dive(paths: Sequence[Path], description: LogDescription = NO_DESCRIPTION) -> Dive:
    """The one dive that files and folders are.

    Raises:
        BadInput: they are several.
    """
    found = dives(paths, description)
    if len(found) == 1:
        return found[0]
    spans = (f"{dive.name}{_span_words(dive)}" for dive in found)
    raise BadInput(f"{' and '.join(spans)} are no parts of one dive: {DIVE_RULE}; give one dive at a time")


def _place(paths: Sequence[Path], path: Path) -> int:
    return paths.index(path) if path in paths else len(paths)


def _span_words(dive: Dive) -> str:
    first, last = dive.parts[0], dive.parts[-1]
    return f" ({first.first:.10g} to {last.last:.10g} s)" if first.placed else ""


def _of_folder(folder: Path, description: LogDescription, opened: Opened) -> Dive:
    """The logs of a folder as one dive."""
    files = [path for path in sorted(folder.iterdir()) if not path.name.startswith(".") and is_log(path)]
    if not files:
        there = ", ".join(sorted(path.name for path in folder.iterdir())[:6]) or "nothing"
        raise BadInput(
            f"{folder}: no file in this folder is a log that can be read here ({there}); give a file, the folder of a "
            "ROS 2 bag or of an archive of `serve`, or a folder with the logs of one dive"
        )
    if len(files) == 1:
        return Dive(files[0], (Part(files[0]),))
    parts = [_part(path, description, opened) for path in files]
    formats = sorted({part.kind[0] for part in parts})
    unknown = next((part for part in parts if part.log is None or not part.placed), None)
    if unknown is not None:
        opened(unknown.path)
        raise BadInput(
            f"{unknown.path}: this part has no time: name its time with --column t=…, or give the files of the dive "
            "without it"
        )
    if len(formats) > 1:
        raise BadInput(
            f"{folder}: it contains logs of several kinds ({', '.join(formats)}); name the files of one kind"
        )
    if len({part.kind for part in parts}) > 1:
        raise BadInput(f"{folder}: some of its logs count since 1970 and others since boot; name the files of one dive")
    ordered = _in_order(parts)
    for one, other in pairwise(ordered):
        if _overlap(one, other):
            raise BadInput(
                f"{folder}: {one.path.name} ({_ends(one)}) and {other.path.name} ({_ends(other)}) overlap in time, so "
                "they are no parts of one dive; name the files instead, each a run of its own"
            )
    return Dive(folder, tuple(ordered))


def _dives_of_files(parts: Sequence[Part]) -> list[Dive]:
    """Files that go on from one to the next together; all apart where any two of one kind overlap."""
    found: list[Dive] = []
    for kind in dict.fromkeys(part.kind for part in parts):
        alike = [part for part in parts if part.kind == kind]
        known = _in_order([part for part in alike if part.placed])
        found += [Dive(part.path, (part,)) for part in alike if not part.placed]
        if any(_overlap(one, other) for one, other in pairwise(known)):
            found += [Dive(part.path, (part,)) for part in known]
            continue
        group: list[Part] = []
        for part in known:
            if group and _pause(group[-1], part) > MAX_PAUSE_S:
                found.append(Dive(group[0].path, tuple(group)))
                group = []
            group.append(part)
        found += [Dive(group[0].path, tuple(group))] if group else []
    return found


def _in_order(parts: Sequence[Part]) -> list[Part]:
    return sorted(parts, key=lambda part: (part.first, part.last))


def _pause(one: Part, other: Part) -> float:
    """The pause from the end of a part to the beginning of another one [s]."""
    return other.first - one.last


def _overlap(one: Part, other: Part) -> bool:
    late = min(MAX_OVERLAP_S, 0.1 * (one.last - one.first), 0.1 * (other.last - other.first))
    return _pause(one, other) < -(0.0 if one.kind[0] == "CSV" else late)


def _ends(part: Part) -> str:
    return f"{part.first:.10g} to {part.last:.10g} s"


def _part(path: Path, description: LogDescription, opened: Opened) -> Part:
    """A file with what is in it; without, where it cannot be read: who reads it next says why."""
    try:
        log = opened(path)
        return Part(path, log, *_span(log, description.of(path.name)))
    except BadInput:
        return Part(path)


def _span(log: Log, description: LogDescription) -> tuple[float, float]:
    """The begin and end of a log [s], by its clock; of a table by its column of time."""
    topics = [topic for topic in log.topics if topic.count]
    if not topics:
        return nan, nan
    if topics[0].name == ROWS:
        inputs = describe(log, description).inputs
        time = writing_times(log.read([ROWS])[ROWS], inputs)
    else:
        busiest = max(topics, key=lambda topic: (topic.count, topic.name)).name
        arrival = log.read([busiest])[busiest].arrival
        time = np.empty(0) if arrival is None else arrival
    known = time[np.isfinite(time)]
    return (float(known.min()), float(known.max())) if known.size else (nan, nan)
