"""Keelson's messages: a protobuf envelope around a stamped value, read without its package.

`core.Envelope` has the payload in field 2; the subjects that are read here hold `keelson.Timestamped…` messages, with
the stamp (`google.protobuf.Timestamp`) in field 1 and the value in field 2. What has other fields is skipped.
"""

from __future__ import annotations

import struct
from typing import Any

_VARINT, _EIGHT, _BYTES, _FOUR = 0, 1, 2, 5


def decode(payload: bytes) -> dict[str, Any]:
    """`timestamp` [s] and `value` of an enveloped message; what was not written is zero, as protobuf has it.

    Raises:
        ValueError: it is no such message.
    """
    envelope = _fields(payload)
    inner = envelope.get(2, b"")
    if not isinstance(inner, bytes):
        raise ValueError("it is no envelope")
    message = _fields(inner)
    stamp, value = message.get(1), message.get(2, 0)
    if not isinstance(stamp, bytes):
        raise ValueError("its payload bears no stamp")
    if isinstance(value, bytes):
        raise ValueError("its payload is no stamped number")
    when = _fields(stamp)
    return {"timestamp": _whole(when.get(1, 0)) + _whole(when.get(2, 0)) * 1e-9, "value": value}


def _fields(content: bytes) -> dict[int, bytes | int | float]:
    """The fields of a message by their numbers; the last of each counts. Fixed widths are floating-point numbers."""
    found: dict[int, bytes | int | float] = {}
    place = 0
    while place < len(content):
        tag, place = _varint(content, place)
        kind = tag & 7
        if kind == _VARINT:
            value, place = _varint(content, place)
            found[tag >> 3] = value - 2**64 if value >= 2**63 else value
        elif kind == _BYTES:
            size, place = _varint(content, place)
            if place + size > len(content):
                raise ValueError("it ends within a field")
            found[tag >> 3] = content[place : place + size]
            place += size
        elif kind in (_EIGHT, _FOUR):
            form = "<d" if kind == _EIGHT else "<f"
            if place + struct.calcsize(form) > len(content):
                raise ValueError("it ends within a field")
            (found[tag >> 3],) = struct.unpack_from(form, content, place)
            place += struct.calcsize(form)
        else:
            raise ValueError("it is no protobuf message")
    return found


def _varint(content: bytes, place: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        if place >= len(content):
            raise ValueError("it ends within a number")
        byte = content[place]
        place += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, place
    raise ValueError("it is no protobuf message")


def _whole(value: bytes | int | float) -> int:
    if isinstance(value, int):
        return value
    raise ValueError("its stamp is none")
