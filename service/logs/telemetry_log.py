"""Telemetry logs of ground stations (.tlog): MAVLink packets with their times of arrival, read by pymavlink.

Everybody on the link is in it. Messages of the vehicle's autopilot keep their plain names (`ATTITUDE`); those of others
are named as BlueOS does, `mavlink/<system>/<component>/<MESSAGE>`. Of several vehicles the one that is chosen for all
(`service.inputs.vehicles`) has the plain names. Each instance of a message is a topic of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.inputs.instances import base, instance_field, numbered
from service.inputs.owners import AUTOPILOT
from service.logs.choosing import chosen
from service.logs.gathering import Gathering
from service.logs.packages import needed
from service.logs.table import Table, Topic

STAMP = 8
"""Bytes of the time of arrival before each packet: µs since 1970, big-endian."""
HEADER = 8
"""Bytes of the shortest packet."""


class TelemetryLog:
    """A telemetry log, read whole: its packets tell nothing without decoding them."""

    def __init__(self, path: Path, gathered: Mapping[tuple[int, int, str], Gathering]) -> None:
        if not gathered:
            raise BadInput(f"{path}: there is no MAVLink message in it; give a telemetry log that a link wrote")
        self.format = "MAVLink telemetry"
        self._system = ""
        self._gathered = {f"mavlink/{of}/{part}/{name}": messages for (of, part, name), messages in gathered.items()}
        self._system = chosen(self).system
        plain = f"mavlink/{self._system}/{AUTOPILOT}/"
        self._gathered = {name.removeprefix(plain): messages for name, messages in self._gathered.items()}

    @property
    def topics(self) -> tuple[Topic, ...]:
        return tuple(
            Topic(
                name,
                base(name.rpartition("/")[2]),
                messages.fields,
                len(messages),
                "" if "/" in name else self._system,
            )
            for name, messages in sorted(self._gathered.items())
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be read: nothing is known of it."""
        return ()

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        return {name: messages.table() for name, messages in self._gathered.items() if name in names}


def open_log(path: Path) -> TelemetryLog:
    """Reads the whole file."""
    dialect = needed("pymavlink.dialects.v20.ardupilotmega", path, "a telemetry log")
    gathered: dict[tuple[int, int, str], Gathering] = {}
    for arrival, message in messages(path.read_bytes(), dialect):
        fields = {name: _plain(getattr(message, name)) for name in message.get_fieldnames()}
        kind = message.get_type()
        which = instance_field(kind)
        key = (
            message.get_srcSystem(),
            message.get_srcComponent(),
            kind if which is None else numbered(kind, fields.get(which)),
        )
        gathered.setdefault(key, Gathering()).add(arrival, fields)
    return TelemetryLog(path, gathered)


def messages(content: bytes, dialect: Any) -> Iterator[tuple[float, Any]]:
    """Time of arrival [s since 1970] and message of each packet, MAVLink 1 and 2.

    Damaged packets, and those of other dialects, are skipped: radio links and companions bring some of them.
    """
    decoder = dialect.MAVLink(None)
    place, end = 0, len(content)
    while place + STAMP + HEADER <= end:
        begin = place + STAMP
        size = _size(content[begin : begin + HEADER])
        if size:
            try:
                message = decoder.decode(bytearray(content[begin : begin + size]))
            except dialect.MAVError:
                message = None
            if message is not None:
                yield int.from_bytes(content[place:begin], "big") * 1e-6, message
            if message is not None or _size(content[begin + size + STAMP : begin + size + STAMP + HEADER]):
                place = begin + size
                continue
        place += 1  # what stands here is no packet: the next one is looked for


def _size(header: bytes) -> int:
    """Bytes of the packet that begins with these; 0 where none does."""
    if len(header) < HEADER:
        return 0
    first, length, flags = header[0], header[1], header[2]
    signature = 13 if flags & 1 else 0
    return {0xFE: 8 + length, 0xFD: 12 + length + signature}.get(first, 0)


def _plain(value: Any) -> Any:
    return value.decode("utf-8", "replace").rstrip("\0") if isinstance(value, bytes) else value
