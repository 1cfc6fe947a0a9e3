"""Telemetry logs of ground stations (.tlog): MAVLink packets with their times of arrival, read by pymavlink.

Everybody on the link is in it. Messages of the vehicle's autopilot keep their plain names (`ATTITUDE`); those of others
are named as BlueOS does, `mavlink/<system>/<component>/<MESSAGE>`. Of several vehicles the one that is chosen for all
(`service.inputs.vehicles`) has the plain names. Each instance of a message is a topic of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.owners import base, instance_field, numbered
from service.inputs.table import Topic
from service.logs.choosing import with_plain_names
from service.logs.log import Damage, Log, TableBuilder
from service.logs.opening import MIN_PACKET_BYTES, STAMP_BYTES, packet_size

MAX_COPY_DELAY_S = 10.0
"""The time by which a second link may be late [s]: a busy sender's sequence numbers, of 8 bits, begin anew after
that."""
LINK_NAME = "the link"
"""The name for the sender of packets that nobody can read."""


def open_log(path: Path) -> Log:
    """Reads the whole file.

    Raises:
        BadInput: it holds no message, or pymavlink is missing.
    """
    dialect = load_package("pymavlink.dialects.v20.ardupilotmega", path, "a telemetry log")
    gathered: dict[str, TableBuilder] = {}
    damage = Damage(path)
    for arrival, message in messages(path.read_bytes(), dialect, damage):
        fields = {name: _plain(getattr(message, name)) for name in message.get_fieldnames()}
        kind = message.get_type()
        which = instance_field(kind)
        name = kind if which is None else numbered(kind, fields.get(which))
        place = f"mavlink/{message.get_srcSystem()}/{message.get_srcComponent()}/{name}"
        gathered.setdefault(place, TableBuilder()).add(arrival, fields)
    if not gathered:
        raise BadInput(f"{path}: there is no MAVLink message in it; give a telemetry log that a link wrote")
    topics = (Topic(name, base(name.rpartition("/")[2]), found.fields, len(found)) for name, found in gathered.items())
    tables = {name: found.table() for name, found in gathered.items()}
    notes = (*(each.note for each in damage.broken), *damage.notes)
    return with_plain_names(Log("MAVLink telemetry", tuple(topics), tables, notes))


def messages(content: bytes, dialect: Any, damage: Damage) -> Iterator[tuple[float, Any]]:
    """Time of arrival [s since 1970] and message of each packet, MAVLink 1 and 2.

    Damaged packets are left out and counted; those of other dialects, which companions bring, are left out. A packet
    that comes again over a second link counts once.
    """
    decoder = dialect.MAVLink(None)
    place, end, read = 0, len(content), 0
    framed, copies = 0, PacketCopies()
    while place + STAMP_BYTES + MIN_PACKET_BYTES <= end:
        begin = place + STAMP_BYTES
        size = packet_size(content[begin : begin + MIN_PACKET_BYTES])
        if size:
            packet, message = content[begin : begin + size], None
            try:
                message = decoder.decode(bytearray(packet))
            except dialect.MAVError as error:
                if framed := packet_size(
                    content[begin + size + STAMP_BYTES : begin + size + STAMP_BYTES + MIN_PACKET_BYTES]
                ):
                    damage.add_broken(LINK_NAME, error)
            if message is not None:
                damage.add_read(LINK_NAME)
                arrival = int.from_bytes(content[place:begin], "big") * 1e-6
                if not copies.is_copy(packet, message, arrival):
                    yield arrival, message
            if message is not None or framed:
                damage.add_skipped(place - read)
                place = read = begin + size
                continue
        place += 1  # what stands here is no packet: the next one is looked for
    damage.add_skipped(end - read)


class PacketCopies:
    """The newest packets, by which one is known that comes again over a second link."""

    def __init__(self) -> None:
        self._came: dict[bytes, float] = {}
        self._numbers: dict[tuple[int, int], int] = {}

    def is_copy(self, packet: bytes, message: Any, arrival: float) -> bool:
        """Whether a packet came before; one of a sender that never counts is not said to."""
        sender, number = (message.get_srcSystem(), message.get_srcComponent()), message.get_seq()
        counts = self._numbers.get(sender, number) != number
        while self._came and arrival - self._came[oldest := next(iter(self._came))] > MAX_COPY_DELAY_S:
            del self._came[oldest]
        again = counts and packet in self._came
        if not again:
            self._numbers[sender] = number
            self._came.setdefault(packet, arrival)
        return again


def _plain(value: Any) -> Any:
    return value.decode("utf-8", "replace").rstrip("\0") if isinstance(value, bytes) else value
