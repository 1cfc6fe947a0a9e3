"""The incoming messages of an archive of `incsvr serve --archive`, to be played again byte for byte."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import zenoh
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.extras import load_package
from service.inputs.forms.own import InvalidMeasurement, parse
from service.logs.cutting import Cut, Span, refuse_empty
from service.logs.opening import ARCHIVE_PROFILE, JSON_ENCODING, METADATA_NAME, archive_files
from service.wire import Keys

_MAGIC = b"\x89MCAP0\r\n"
_HEADER = 1 + 8 + 4
"""Before the profile in the first record [bytes]: its kind, its length, and the length of the profile."""


@dataclass(frozen=True, slots=True)
class ArchiveReader:
    """The messages that came, in the order in which the learner took them, as in `simulator.messages.Messages`.

    Attributes:
        name: of the archive.
        prefix: of the learner that kept it.
        topics, encodings: of each stream, as they were.
        stream: (n,) position in `topics`.
        send: (n,) when it was taken, by the clock on the wall, not decreasing [s].
        payloads: n of them.
    """

    name: str
    prefix: str
    topics: tuple[str, ...]
    encodings: tuple[str, ...]
    stream: NDArray[np.intp]
    send: Array
    payloads: Sequence[bytes]

    @staticmethod
    def read(paths: Sequence[Path]) -> ArchiveReader:
        """Reads all files of archives, up to where each ends or is damaged, as after a power cut.

        Raises:
            BadInput: a file is no archive, they are of several learners, or nothing came.
        """
        files = [file for path in paths for file in (archive_files(path) if path.is_dir() else [path])]
        prefixes: set[str] = set()
        streams: dict[tuple[str, str], int] = {}
        stream: list[int] = []
        send: list[float] = []
        payloads: list[bytes] = []
        for file in files:
            if not is_archive(file):
                raise BadInput(
                    f"{file}: this is no archive of `serve`; play archives and other logs one after the other"
                )
            prefix, messages = _messages(file)
            prefixes.add(prefix)
            own = _published(prefix)
            for key, encoding, at, payload in messages:
                if key not in own:
                    stream.append(streams.setdefault((key, encoding), len(streams)))
                    send.append(at)
                    payloads.append(payload)
        if len(prefixes) > 1:
            raise BadInput(
                f"{paths[0]}: these are archives of {', '.join(sorted(prefixes))}; play one of them at a time"
            )
        if not payloads:
            raise BadInput(f"{paths[0]}: no message arrived while it was written")
        topics, encodings = zip(*streams, strict=True)
        times = np.maximum.accumulate(np.array(send))
        name = paths[0].name if len(paths) == 1 else f"{paths[0].name} and {len(paths) - 1} more"
        return ArchiveReader(name, prefixes.pop(), topics, encodings, np.array(stream), times, payloads)

    def within(self, cut: Cut) -> ArchiveReader:
        """The messages within a cut: seconds count from the first message, times of day are the wall's.

        Raises:
            EmptyCut: nothing came in it.
        """
        if not cut:
            return self
        span = Span(float(self.send[0]), float(self.send[-1]), 0.0)
        low, high = cut.ends(span)
        inside = (self.send >= low) & (self.send <= high)
        refuse_empty(cut, inside, span)
        payloads = [self.payloads[k] for k in np.flatnonzero(inside)]
        return replace(self, stream=self.stream[inside], send=self.send[inside], payloads=payloads)

    @property
    def names(self) -> tuple[str, ...]:
        """The streams as the learner calls them, where they came on its own keys."""
        keys = Keys(self.prefix)
        called = {keys.rate: "yaw_rate", keys.torque: "torque"}
        return tuple(called.get(topic, topic) for topic in self.topics)

    def __len__(self) -> int:
        return len(self.payloads)

    def key(self, stream: int, keys: Keys) -> tuple[str, zenoh.Encoding]:
        """The key of a message, below the prefix of the present learner."""
        topic, encoding = self.topics[stream], self.encodings[stream]
        below = topic.removeprefix(f"{self.prefix}/")
        place = topic if below == topic else f"{keys.prefix}/{below}"
        return place, zenoh.Encoding.APPLICATION_JSON if encoding == JSON_ENCODING else zenoh.Encoding(encoding)

    def payload(self, index: int, sequence: int) -> bytes:
        """The payload as it arrived."""
        return self.payloads[index]

    def values(self, stream: int) -> int:
        """The number of values of a stream in our own form."""
        return sum(_values(self.payloads[index]) for index in np.flatnonzero(self.stream == stream).tolist())


def _values(payload: bytes) -> int:
    """The number of values of a message in our own form; zero if it is refused."""
    try:
        return len(parse(payload)[0])
    except InvalidMeasurement:
        return 0


def is_archive(path: Path) -> bool:
    """Whether it is a folder or a file that `serve --archive` wrote."""
    if path.is_dir():
        return any(is_archive(file) for file in archive_files(path)[:1])
    try:
        with path.open("rb") as file:
            head = file.read(len(_MAGIC) + _HEADER + len(ARCHIVE_PROFILE))
    except OSError:
        return False
    return head.startswith(_MAGIC) and head[len(_MAGIC) + _HEADER :] == ARCHIVE_PROFILE.encode()


def _published(prefix: str) -> set[str]:
    keys = Keys(prefix)
    return {keys.model, keys.iteration, keys.health, keys.effects, keys.coefficients, keys.estimate}


def _messages(path: Path) -> tuple[str, list[tuple[str, str, float, bytes]]]:
    """Prefix of the learner, and its messages: key, encoding, time [s], payload."""
    stream_reader = load_package("mcap.stream_reader", path, "an archive")
    records = load_package("mcap.records", path, "an archive")
    prefix, channels, found = "", dict[int, Any](), list[tuple[str, str, float, bytes]]()
    # mcap raises what its decompressors do, too: where a file was cut, it ends.
    with path.open("rb") as file, suppress(Exception):
        for record in stream_reader.StreamReader(file).records:
            if isinstance(record, records.Metadata) and record.name == METADATA_NAME:
                prefix = record.metadata["prefix"]
            elif isinstance(record, records.Channel):
                channels[record.id] = record
            elif isinstance(record, records.Message):
                channel = channels[record.channel_id]
                found.append((channel.topic, channel.message_encoding, record.log_time * 1e-9, record.data))
    return prefix, found
