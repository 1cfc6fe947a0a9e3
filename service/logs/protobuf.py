"""Protobuf messages by the descriptors that an MCAP file holds, as Keelson's recorder writes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from service.logs.packages import load_package

_TIMESTAMP = "google.protobuf.Timestamp"
_DURATION = "google.protobuf.Duration"


class ProtobufType:
    """One type of message, by the set of file descriptors that defines it."""

    def __init__(self, path: Path, name: str, descriptors: bytes) -> None:
        pool = load_package("google.protobuf.descriptor_pool", path, "a protobuf message").DescriptorPool()
        sets = load_package("google.protobuf.descriptor_pb2", path, "a protobuf message")
        factory = load_package("google.protobuf.message_factory", path, "a protobuf message")
        for each in _in_import_order(sets.FileDescriptorSet.FromString(descriptors).file):
            pool.Add(each)
        self._message = factory.GetMessageClass(pool.FindMessageTypeByName(name))

    def decode(self, payload: bytes) -> dict[str, Any]:
        """The fields of a message, nested; stamps and durations as seconds, enumerations as numbers."""
        return _fields(self._message.FromString(payload))


def _in_import_order(files: Any) -> list[Any]:
    """The files, each after those that it imports."""
    known = {each.name: each for each in files}
    done: dict[str, Any] = {}

    def add(name: str) -> None:
        if name in known and name not in done:
            for dependency in known[name].dependency:
                add(dependency)
            done[name] = known[name]

    for name in known:
        add(name)
    return list(done.values())


def _fields(message: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.message_type is None:
            found[field.name] = list(value) if _repeated(value) else value
        elif _repeated(value):
            if not hasattr(value, "keys"):
                found[field.name] = [_nested(item) for item in value]
        elif message.HasField(field.name):
            found[field.name] = _nested(value)
    return found


def _nested(value: Any) -> Any:
    if value.DESCRIPTOR.full_name in (_TIMESTAMP, _DURATION):
        return value.seconds + value.nanos * 1e-9
    return _fields(value)


def _repeated(value: Any) -> bool:
    return hasattr(value, "__len__") and not isinstance(value, str | bytes)
