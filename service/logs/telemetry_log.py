"""Telemetry logs of ground stations (.tlog): MAVLink packets with their times of arrival, read by pymavlink.

Everybody on the link is in it. Messages of the vehicle's autopilot keep their plain names (`ATTITUDE`); those of others
are named as BlueOS does, `mavlink/<system>/<component>/<MESSAGE>`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.logs.gathering import Gathering
from service.logs.packages import needed
from service.logs.table import Table, Topic

AUTOPILOT = 1
"""The component that flies (MAV_COMP_ID_AUTOPILOT1)."""
INVALID = 8
"""MAV_AUTOPILOT_INVALID: a heartbeat of somebody who is no autopilot."""
STAMP = 8
"""Bytes of the time of arrival before each packet: µs since 1970, big-endian."""
HEADER = 8
"""Bytes of the shortest packet."""


class TelemetryLog:
    """A telemetry log, read whole: its packets tell nothing without decoding them."""

    def __init__(self, path: Path, gathered: Mapping[tuple[int, int, str], Gathering]) -> None:
        self.format = "MAVLink telemetry"
        vehicle = _vehicle(gathered)
        self._gathered = {_name(key, vehicle): (key, messages) for key, messages in gathered.items()}
        if not gathered:
            raise BadInput(f"{path}: there is no MAVLink message in it; give a telemetry log that a link wrote")

    @property
    def topics(self) -> tuple[Topic, ...]:
        return tuple(
            Topic(name, key[2], messages.fields, len(messages))
            for name, (key, messages) in sorted(self._gathered.items())
        )

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        return {name: messages.table() for name, (_, messages) in self._gathered.items() if name in names}


def open_log(path: Path) -> TelemetryLog:
    """Reads the whole file."""
    dialect = needed("pymavlink.dialects.v20.ardupilotmega", path, "a telemetry log")
    gathered: dict[tuple[int, int, str], Gathering] = {}
    for arrival, message in messages(path.read_bytes(), dialect):
        key = (message.get_srcSystem(), message.get_srcComponent(), message.get_type())
        fields = {name: _plain(getattr(message, name)) for name in message.get_fieldnames()}
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


def _vehicle(gathered: Mapping[tuple[int, int, str], Gathering]) -> int | None:
    """The system whose autopilot says the most."""
    said: Counter[int] = Counter()
    for (system, component, kind), messages in gathered.items():
        if component == AUTOPILOT and not (kind == "HEARTBEAT" and _no_autopilot(messages)):
            said[system] += len(messages)
    return max(said, key=said.__getitem__, default=None)


def _no_autopilot(messages: Gathering) -> bool:
    return bool((messages.table().columns["autopilot"] == INVALID).all())


def _name(key: tuple[int, int, str], vehicle: int | None) -> str:
    system, component, kind = key
    return kind if (system, component) == (vehicle, AUTOPILOT) else f"mavlink/{system}/{component}/{kind}"
