"""A cut of a log: `--from` and `--to`, in seconds of the log or as a time of day, and the instants they stand for."""

from __future__ import annotations

import argparse
import math
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams
from service.number import number_of

MIN_STAMP_SINCE_1970_S = 1e9
"""The stamp beyond which stamps are seconds since 1970 (2001) [s]; a log's own clock never shows so many."""
DAY_S = 86400.0
"""Seconds of a day."""
ARMED_CHANNEL = "armed"
"""The channel that says whether the vehicle was armed, often only where that changes."""
_OF_DAY = re.compile(r"^(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?$")
CUT_HELP = "seconds of the log's stamps, or from its beginning where stamps count since 1970; or a time of day in UTC"


@dataclass(frozen=True, slots=True)
class Instant:
    """An end of a cut.

    Attributes:
        text: as it was typed.
        seconds: of the log, or since midnight [s].
        of_day: whether it is a time of day.
    """

    text: str
    seconds: float
    of_day: bool


@dataclass(frozen=True, slots=True)
class Span:
    """The time span of a log.

    Attributes:
        first, last: its first and last stamp [s].
        since_1970: what makes seconds since 1970 of a stamp [s]; None where nothing in the log says it.
    """

    first: float
    last: float
    since_1970: float | None = None

    @property
    def origin(self) -> float:
        """The stamp from which a person counts the seconds of the log [s]."""
        return self.first if self.first >= MIN_STAMP_SINCE_1970_S else 0.0

    def __str__(self) -> str:
        seconds = f"{self.first - self.origin:.6g} to {self.last - self.origin:.6g} s"
        if self.since_1970 is None:
            return seconds
        ends = (datetime.fromtimestamp(end + self.since_1970, UTC) for end in (self.first, self.last))
        return f"{seconds} ({' to '.join(f'{end:%H:%M:%S}' for end in ends)} UTC)"


class EmptyCut(BadInput):
    """A cut holds nothing of a log."""


@dataclass(frozen=True, slots=True)
class Cut:
    """The part of a log from one instant to another; None is the log's own end."""

    begin: Instant | None = None
    end: Instant | None = None

    @staticmethod
    def of(args: Any) -> Cut:
        """The cut by the flags of `add_cut_arguments`, as attributes.

        Raises:
            BadInput: it ends before it begins.
        """
        begin: Instant | None = args.cut_from
        end: Instant | None = args.cut_to
        in_seconds = begin is not None and end is not None and not (begin.of_day or end.of_day)
        if begin is not None and end is not None and in_seconds and begin.seconds >= end.seconds:
            raise BadInput(f"--from {begin.text} is not before --to {end.text}: give an end that comes after the begin")
        return Cut(begin, end)

    def __bool__(self) -> bool:
        return self.begin is not None or self.end is not None

    def __str__(self) -> str:
        ends = (("--from", self.begin), ("--to", self.end))
        return " ".join(f"{flag} {end.text}" for flag, end in ends if end is not None)

    def ends(self, span: Span) -> tuple[float, float]:
        """The begin and end [s], by the stamps of a log with this span.

        Raises:
            BadInput: a time of day is asked for, and nothing in the log says it.
        """
        low = -math.inf if self.begin is None else _stamp(self.begin, span, span.first)
        high = math.inf if self.end is None else _stamp(self.end, span, max(low, span.first))
        return low, high


WHOLE_LOG = Cut()
"""No cut."""


def instant(text: str) -> Instant:
    """An end of a cut, as a type of argparse."""
    of_day = _OF_DAY.match(text.strip())
    if of_day:
        hours, minutes, seconds = int(of_day[1]), int(of_day[2]), float(of_day[3] or 0.0)
        if hours < 24 and minutes < 60 and seconds < 60.0:
            return Instant(text, 3600.0 * hours + 60.0 * minutes + seconds, True)
    try:
        value = number_of(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(
            f"it is {text}; give seconds of the log as in 421.5, or a time of day as 14:05:30"
        )
    return Instant(text, value, False)


def add_cut_arguments(parser: argparse.ArgumentParser) -> None:
    """The flags `--from` and `--to`."""
    parser.add_argument(
        "--from", dest="cut_from", type=instant, metavar="T", help=f"begin of the part that is used: {CUT_HELP}"
    )
    parser.add_argument("--to", dest="cut_to", type=instant, metavar="T", help="end of the part that is used")


def since_1970(stamps: Array, arrival: Array | None) -> float | None:
    """The offset of stamps (n,) [s] to seconds since 1970; None if neither they nor the times of arrival show it."""
    known = stamps[np.isfinite(stamps)]
    if not known.size:
        return None
    if MIN_STAMP_SINCE_1970_S <= np.median(known) < 10.0 * MIN_STAMP_SINCE_1970_S:
        return 0.0
    came = np.empty(0) if arrival is None else arrival[np.isfinite(arrival)]
    if not came.size or not MIN_STAMP_SINCE_1970_S <= np.median(came) < 10.0 * MIN_STAMP_SINCE_1970_S:
        return None
    return float(np.median(came) - np.median(known))


def refuse_empty(cut: Cut, inside: NDArray[np.bool_], span: Span) -> None:
    """Raises EmptyCut where a cut holds none of (n,) stamps of a log."""
    if not inside.any():
        raise EmptyCut(f"{cut} selects no data of this log, which spans {span}")


def streams_inside(streams: Streams, low: float, high: float) -> dict[str, Stream]:
    """The streams from one stamp to another [s]; `armed` begins with what it was before the first value."""
    found = dict[str, Stream]()
    for name, (time, values) in streams.items():
        inside = (time >= low) & (time <= high)
        found[name] = time[inside], values[inside]
    begins = [time[0] for time, _ in found.values() if time.size]
    if ARMED_CHANNEL in found and begins:
        (time, values), (stamps, said) = found[ARMED_CHANNEL], streams[ARMED_CHANNEL]
        before = int(np.searchsorted(stamps, low))
        if before and min(begins) not in time[:1]:
            found[ARMED_CHANNEL] = np.insert(time, 0, min(begins)), np.insert(values, 0, said[before - 1])
    return found


def _stamp(end: Instant, span: Span, after: float) -> float:
    """The stamp of an end [s]; a time of day is the first one in the log that is not before `after`."""
    if not end.of_day:
        return end.seconds if end.seconds >= MIN_STAMP_SINCE_1970_S else end.seconds + span.origin
    if span.since_1970 is None:
        raise BadInput(f"this log does not know the time of day {end.text}: give seconds, it spans {span}")
    midnight = (span.first + span.since_1970) // DAY_S * DAY_S
    stamp = midnight + end.seconds - span.since_1970
    goes_on = midnight + DAY_S <= span.last + span.since_1970
    return stamp + DAY_S if stamp < after and goes_on else stamp
