"""What is said on a vehicle's link, once: as a telemetry log, as BlueOS records and publishes it, and as DataFlash.

The messages are pymavlink's; each test says what is in them.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from pymavlink.dialects.v20 import ardupilotmega as link

from tests.service.logs.autopilot_files import Dataflash
from tests.service.logs.dive import BOOT, EPOCH, PARAMETERS, VOLTS, YAW, Dive

SUBMARINE, STATION, BOAT, COMPANION = 12, 6, 11, 18
ARMED, DISARMED = 209, 81
Outputs = tuple[int, ...]


@dataclass(frozen=True)
class Said:
    """A message, when it arrives [s since the log began], and whose it is."""

    at: float
    message: Any
    system: int = 1
    component: int = 1


def heartbeat(at: float, armed: bool, kind: int = SUBMARINE, autopilot: int = 3) -> Said:
    mode = ARMED if armed else DISARMED
    return Said(at, link.MAVLink_heartbeat_message(kind, autopilot, mode, 19, 4, 3))


def parameter(at: float, name: str, value: float) -> Said:
    return Said(at, link.MAVLink_param_value_message(name.encode(), value, 9, 900, 0))


def parameters(at: float = 0.0, **over: float) -> list[Said]:
    return [parameter(at, name, value) for name, value in {**PARAMETERS, **over}.items()]


def attitude(at: float, rate: float, boot: float = BOOT, yaw: float = 0.0) -> Said:
    stamp = round(1000 * (boot + at))
    return Said(at + 0.01, link.MAVLink_attitude_message(stamp, 0.0, 0.0, yaw, 0.0, 0.0, rate))


def outputs(at: float, pulses: Sequence[float], port: int = 0, boot: float = BOOT) -> Said:
    """Up to sixteen outputs of a bank; the rest bear no pulse."""
    every = [*(int(pulse) for pulse in pulses), *[0] * (16 - len(pulses))]
    stamp = (round(1e6 * (boot + at)) + 130 * port) % 2**32
    return Said(at + 0.012 + 0.001 * port, link.MAVLink_servo_output_raw_message(stamp, port, *every))


def battery(at: float, volts: float = VOLTS, which: int = 0) -> Said:
    cells = [round(1000 * volts), *[65535] * 9]
    return Said(at, link.MAVLink_battery_status_message(which, 0, 1, 2000, cells, 100, 5, 5, 90))


def pulses(dive: Dive, directions: Sequence[int]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(n, 4) what motors 1 … 4 are told [µs] where they count in these directions."""
    return np.round(1500.0 + np.outer(dive.command, 400.0 * np.array(YAW) * np.array(directions)))


def swum(
    dive: Dive, told: Any = None, armed_from: float = 5.0, kind: int = SUBMARINE, boot: float = BOOT
) -> list[Said]:
    """A dive as its autopilot tells it, without its parameters.

    Args:
        told: (n, k) its outputs, if they are not those of `Dive.pulses`.
        boot: what its clock shows at first [s].
    """
    found: list[Said] = []
    for k, (t, rate, row) in enumerate(zip(dive.time, dive.rate, dive.pulses if told is None else told, strict=True)):
        if k == 0 or int(t) != int(dive.time[k - 1]):
            found += [heartbeat(t, t >= armed_from, kind), battery(t)]
        found += [attitude(t, rate, boot), outputs(t, row, boot=boot)]
    return found


def others(seconds: int) -> list[Said]:
    """The heartbeats of a ground station and of a companion, which have the bit of arming, too."""
    return [
        replace(heartbeat(float(t), True, kind, 8), system=system, component=component)
        for t in range(seconds)
        for kind, system, component in ((STATION, 255, 190), (COMPANION, 1, 194))
    ]


def of(system: int, said: Iterable[Said]) -> list[Said]:
    """The same messages, sent by another system."""
    return [replace(each, system=system) for each in said]


def in_order(*parts: Iterable[Said]) -> list[Said]:
    """The messages of several in the order of their arrival."""
    return sorted((each for part in parts for each in part), key=lambda each: each.at)


def packets(said: Iterable[Said], first: bool = False) -> Iterator[tuple[float, bytes]]:
    """Arrival [s] and bytes of each message; `first` packs them as MAVLink 1 does."""
    senders: dict[tuple[int, int], Any] = {}
    for each in said:
        who = (each.system, each.component)
        packed = bytes(each.message.pack(senders.setdefault(who, link.MAVLink(None, *who))))
        yield each.at, _first_link(each) if first else packed


SHORT = {"SERVO_OUTPUT_RAW": 21, "BATTERY_STATUS": 36}
"""Bytes of a message in MAVLink 1, which ends before the fields that MAVLink 2 added: outputs 9 to 16."""


def _first_link(said: Said) -> bytes:
    message = said.message
    payload = bytes(message.get_payload()).ljust(message.unpacker.size, b"\0")
    payload = payload[: SHORT.get(message.get_type(), len(payload))]
    head = bytes([len(payload), 0, said.system, said.component, message.get_msgId()])
    checksum = link.x25crc(head + payload + bytes([message.crc_extra])).crc
    return bytes([0xFE]) + head + payload + int(checksum).to_bytes(2, "little")


def as_tlog(path: Path, said: Iterable[Said], first: bool = False, begin: float = EPOCH) -> Path:
    """As a ground station writes it, whose clock shows `begin` at first [s since 1970]."""
    stamped = (struct.pack(">Q", round(1e6 * (begin + at))) + packet for at, packet in packets(said, first))
    path.write_bytes(b"".join(stamped))
    return path


def wire(message: Any) -> dict[str, Any]:
    """The fields as they are after a link: packed, and decoded again."""
    packed = message.pack(link.MAVLink(None))
    return dict(link.MAVLink(None).decode(bytearray(packed)).to_dict())


def as_key(said: Said, **over: Any) -> tuple[str, bytes]:
    """Key and payload, as BlueOS's server publishes them; `over` says fields that JSON has in another form."""
    fields = wire(said.message)
    kind = fields.pop("mavpackettype")
    if "type" in fields:
        fields["mavtype"] = fields.pop("type")
    if kind == "HEARTBEAT":
        fields["base_mode"] = {"bits": said.message.base_mode}
    if kind == "PARAM_VALUE":
        fields["param_id"] = list(fields["param_id"].ljust(16, "\0"))
    header = {"system_id": said.system, "component_id": said.component, "sequence": 17}
    header["message_id"] = said.message.get_msgId()
    content = {"header": header, "message": {"type": kind, **fields, **over}}
    return f"mavlink/{said.system}/{said.component}/{kind}", json.dumps(content).encode()


def as_keys(said: Iterable[Said]) -> list[tuple[str, bytes]]:
    return [as_key(each) for each in said]


def published(dive: Dive, first: float = 0.0, last: float = 1e9) -> list[tuple[str, bytes]]:
    """What is on the bus of a vehicle that is armed between two times [s], others' heartbeats, too."""
    said = in_order(swum(dive, armed_from=0.0), others(int(dive.time[-1]) + 1))
    return as_keys(each for each in said if first <= each.at < last)


def as_mcap(path: Path, said: Iterable[Said], finish: bool = True) -> Path:
    """As BlueOS's recorder writes it: each key a channel, by the recorder's clock; `finish` writes index and end."""
    said = list(said)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=4096, compression=CompressionType.ZSTD)
        writer.start()
        channels: dict[str, int] = {}
        for each, (key, payload) in zip(said, as_keys(said), strict=True):
            if key not in channels:
                channels[key] = writer.register_channel(key, "json", 0)
            when = round(1e9 * (EPOCH + each.at))
            writer.add_message(channels[key], when, payload, when)
        if finish:
            writer.finish()  # type: ignore[no-untyped-call]
    return path


def as_dataflash(
    path: Path,
    said: Iterable[Said],
    events: bool = True,
    gyros: int = 1,
    told: tuple[str, Mapping[float, int]] | None = None,
) -> Path:
    """What the autopilot of system 1 writes down itself, by its own clock: where its messages have stamps, by these.

    Args:
        events: whether the arming is written down.
        gyros: so many of them; the others are off by 0.5 rad/s each.
        told: instead of the arming, what `ARM` or `EV` says, by its time [s].
    """
    message_of_arming, words = told or ("ARM", {})
    waiting = sorted(words.items())
    log = Dataflash()
    log.define("PARM", "QNf", "TimeUS,Name,Value")
    log.define("IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    log.define("RCOU", "Q" + "H" * 14, "TimeUS," + ",".join(f"C{k}" for k in range(1, 15)))
    log.define("RCO3", "Q" + "H" * 14, "TimeUS," + ",".join(f"C{k}" for k in range(19, 33)))
    log.define("BAT", "QBf", "TimeUS,Instance,Volt")
    log.define(message_of_arming, "QB", "TimeUS,ArmState" if message_of_arming == "ARM" else "TimeUS,Id")
    log.define("MSG", "QZ", "TimeUS,Message")
    armed = False
    for each in said:
        if (each.system, each.component) != (1, 1):
            continue
        while waiting and waiting[0][0] <= each.at:
            log.add(message_of_arming, round(1e6 * (BOOT + waiting[0][0])), waiting.pop(0)[1])
        message, kind = each.message, each.message.get_type()
        stamp = round(1e6 * (BOOT + each.at))
        if kind == "PARAM_VALUE":
            log.add("PARM", stamp, message.param_id.encode(), message.param_value)
        elif kind == "ATTITUDE":
            for which in range(gyros):
                rate = message.yawspeed + 0.5 * which
                log.add("IMU", 1000 * message.time_boot_ms, which, 0.0, 0.0, rate, 0.0, 0.0, -9.8)
        elif kind == "SERVO_OUTPUT_RAW":
            row = [getattr(message, f"servo{k}_raw") for k in range(1, 17)]
            log.add(
                *(("RCO3", message.time_usec, *row[2:]) if message.port else ("RCOU", message.time_usec, *row[:14]))
            )
        elif kind == "BATTERY_STATUS":
            log.add("BAT", stamp, message.id, 1e-3 * message.voltages[0])
        elif kind == "STATUSTEXT":
            log.add("MSG", stamp, message.text.encode())
        elif kind == "HEARTBEAT" and events and told is None and bool(message.base_mode & 128) != armed:
            armed = not armed
            log.add("ARM", stamp, int(armed))
    return log.save(path)


def firmware(at: float, text: str) -> Said:
    return Said(at, link.MAVLink_statustext_message(6, text.encode()))


WRITERS: dict[str, Callable[..., Path]] = {"tlog": as_tlog, "mcap": as_mcap, "BIN": as_dataflash}
"""Suffix of a file → what writes it."""
