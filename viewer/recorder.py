"""Where pages log to: the live stream and the file, each for itself, so that a full disk never stops the live view."""

from __future__ import annotations

import logging
import secrets
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.components import MarkerShape

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import AxisWords, words_of
from viewer.frame import APPLICATION, ITERATION, VEHICLE_TIME, WALL_TIME, Floats
from viewer.palette import SERIES, Colour
from viewer.pauses import Pauses

log = logging.getLogger(__name__)

LIVE_MEMORY = "256MiB"  # of the past that a viewer which comes late is given; what is older is forgotten
FLUSH_S = 5.0


@dataclass(frozen=True, slots=True)
class Look:
    """How a series is drawn over time.

    Attributes:
        title: of the legend.
        colour: None takes the next one beside its neighbours'.
        size: the width of a line, the radius of a mark [points].
        mark: None is a line, which ends at its pauses.
    """

    title: str
    colour: Colour | None = None
    size: float = 1.6
    mark: MarkerShape | None = None


class Recorder:
    """Logs to a file, to viewers at a loopback port, or to both.

    Both streams carry the same recording. They do not share one stream with two sinks: there, a file that cannot be
    written any more silences the live sink too.
    """

    def __init__(
        self, blueprint: rrb.Blueprint, *, path: Path | None = None, port: int | None = None, axis: Axis = YAW
    ) -> None:
        self.axis, self.path = axis, path
        self.broken = False  # the file could not be written to its end
        self._file: rr.RecordingStream | None = None
        self._live: rr.RecordingStream | None = None
        self._stuck: rr.RecordingStream | None = None
        self._series: dict[str, Pauses | None] = {}  # where a line ends; None is of marks
        # Later recordings sort after earlier ones.
        recording = f"{datetime.now(UTC):%Y%m%dT%H%M%S.%f}-{secrets.token_hex(3)}"
        if port is not None:
            sink = rr.GrpcServerSink("127.0.0.1", port, server_memory_limit=LIVE_MEMORY)
            self._live = _stream(recording, sink, blueprint)
        if path is not None:
            self._file = _stream(recording, rr.FileSink(str(path)), blueprint)

    @property
    def _streams(self) -> list[rr.RecordingStream]:
        return [stream for stream in (self._file, self._live) if stream is not None]

    @property
    def words(self) -> AxisWords:
        """What texts and labels call the quantities of the axis."""
        return words_of(self.axis)

    def log(self, path: str, *parts: Any, static: bool = False) -> None:
        for stream in self._streams:
            stream.log(path, *parts, static=static)

    def write(self, path: str, markdown: str) -> None:
        """A text."""
        self.log(path, rr.TextDocument(markdown, media_type="text/markdown"))

    def scalar(self, path: str, look: Look, value: float) -> None:
        """One value of a series, at the clocks that are set."""
        self._style(path, look)
        self.log(path, rr.Scalars(value))

    def series(self, path: str, look: Look, time: Floats, values: Floats, seen: Floats | None = None) -> None:
        """Values (n,) of a series, each at its vehicle's time [s], come in at `seen` [s since 1970]."""
        pauses = self._style(path, look)
        at, drawn = (time, values) if pauses is None else pauses.broken(time, values)
        clocks = [rr.TimeColumn(VEHICLE_TIME, duration=at)]
        if seen is not None:
            # A point that ends a line came in with the one after it.
            seen = np.interp(at, time, seen) if at.size > time.size else seen
            clocks.append(rr.TimeColumn(WALL_TIME, timestamp=seen))
        for stream in self._streams:
            stream.send_columns(path, clocks, rr.Scalars.columns(scalars=drawn))

    def _style(self, path: str, look: Look) -> Pauses | None:
        """Says how a series looks before its first value; where its line ends."""
        if path not in self._series:
            number = sum(each.rpartition("/")[0] == path.rpartition("/")[0] for each in self._series)
            colour = look.colour or SERIES[number % len(SERIES)]
            if look.mark is None:
                style: Any = rr.SeriesLines(colors=colour, names=look.title, widths=look.size)
            else:
                style = rr.SeriesPoints(colors=colour, names=look.title, markers=look.mark, marker_sizes=look.size)
            self.log(path, style, static=True)
            self._series[path] = Pauses() if look.mark is None else None
        return self._series[path]

    def lay_out(self, blueprint: rrb.Blueprint) -> None:
        """Lays the pages out anew, here and whenever the recording is opened."""
        for stream in self._streams:
            stream.send_blueprint(blueprint)

    def set_clocks(
        self, *, iteration: int | None = None, vehicle: float | None = None, wall: float | None = None
    ) -> None:
        """Sets the clocks of what is logged next: iteration, vehicle [s], wall [s since 1970]; None leaves one out."""
        for stream in self._streams:
            stream.reset_time()
            if iteration is not None:
                stream.set_time(ITERATION, sequence=iteration)
            if vehicle is not None:
                stream.set_time(VEHICLE_TIME, duration=vehicle)
            if wall is not None:
                stream.set_time(WALL_TIME, timestamp=wall)

    def flush(self) -> bool:
        """Brings all to the file, so that even kill -9 leaves it there; False once the file had to be given up."""
        if self._file is not None:
            try:
                self._file.flush(timeout_sec=FLUSH_S)
            except RuntimeError as error:
                what = "%s cannot be written any more (%s): is the disk full? It ends here, readable up to this point."
                log.error(what, self.path, error)
                # Closing it, or letting go of it, would wait for ever for a disk that takes nothing.
                self._stuck, self._file, self.broken = self._file, None, True
        return not self.broken

    def close(self) -> None:
        """Ends the file properly; nothing may be logged any more."""
        self.flush()
        for stream in self._streams:
            stream.disconnect()
        self._file = self._live = None


def _stream(recording: str, sink: Any, blueprint: rrb.Blueprint) -> rr.RecordingStream:
    stream = rr.RecordingStream(APPLICATION, recording_id=recording)
    # The three clocks of ours are enough: a fourth one would cost every row as much again.
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    stream.set_sinks(sink, default_blueprint=blueprint)
    return stream
