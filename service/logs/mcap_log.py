"""MCAP files: JSON as BlueOS and our archive record it, CDR of ROS 2, messages of ROS 1, protobuf as of Keelson."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.forms import json_message
from service.inputs.owners import mavlink_topic
from service.inputs.table import Topic
from service.logs.bag_log import RosTypes
from service.logs.log import Damage, Log, TableBuilder
from service.logs.opening import archive_files

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


Decode = Callable[[bytes], Any]


class McapReader:
    """MCAP files, one after the other, read from their beginning: one that was never finished is read as well."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._damage = Damage(path)
        self._ros: dict[bool, RosTypes] = {}
        self._decoders: dict[tuple[int, str], Decode | None] = {}

    def read(self, files: Sequence[Path]) -> Log:
        """All messages."""
        counts, kinds, gathered = Counter[str](), dict[str, str](), dict[str, TableBuilder]()
        for path in files:
            for schema, channel, message in self._messages(path):
                read = self._decoded(schema, channel, message)
                name = mavlink_topic(channel.topic, read)
                counts[name] += 1
                kinds.setdefault(name, schema.name if schema else channel.message_encoding)
                table = gathered.setdefault(name, TableBuilder())
                for each in () if read is None else _each(read):
                    table.add(message.log_time * 1e-9, each)
        if not counts:
            raise BadInput(
                f"{self._path}: there is no message in it; record again, and let the recorder finish the file"
            )
        topics = (Topic(name, kinds[name], found.fields, counts[name]) for name, found in sorted(gathered.items()))
        tables = {name: found.table() for name, found in gathered.items() if len(found)}
        return Log("MCAP", tuple(topics), tables, self._damage.notes, self._damage.broken)

    def _messages(self, path: Path) -> Iterator[tuple[Any, Any, Any]]:
        """Schema, channel and message, as they were written, up to where the file ends or is damaged."""
        reader = load_package("mcap.reader", path, "an MCAP file")
        first, last = None, 0
        with path.open("rb") as file:
            try:
                for found in reader.NonSeekingReader(file).iter_messages(log_time_order=False):
                    last = found[2].log_time
                    first = last if first is None else first
                    yield found
            except Exception as error:  # mcap raises what its decompressors do, too
                if first is not None:
                    self._damage.add_end(path.name, (last - first) * 1e-9, error)
                else:
                    raise BadInput(
                        f"{path}: cannot be read as MCAP ({error or type(error).__name__}); mend it with "
                        "`mcap recover`, or record it again"
                    ) from None

    def _decoded(self, schema: Any, channel: Any, message: Any) -> Any:
        """A message decoded; empty where nothing here reads it, None where it is broken."""
        key = (channel.schema_id, channel.message_encoding)
        if key not in self._decoders:
            self._decoders[key] = self._decoder(schema, channel.message_encoding)
        decode = self._decoders[key]
        if decode is None:
            return {}
        try:
            read = decode(message.data)
        except Exception as error:  # bytes that end early raise whatever reads them
            self._damage.add_broken(channel.topic, error)
            return None
        self._damage.add_read(channel.topic)
        return read

    def _decoder(self, schema: Any, encoding: str) -> Decode | None:
        """The decoder of a channel's messages; None for forms that are not read, such as pictures."""
        name = schema.name if schema else ""
        if encoding == "json":
            return json_message
        if encoding in ("cdr", "ros1") and schema:
            one = encoding == "ros1"
            types = self._ros.setdefault(one, RosTypes(self._path, one))
            if schema.data:
                types.define(name, schema.data.decode("utf-8", "replace"), "idl" in schema.encoding)
            return (lambda payload: types.decode(payload, name)) if types.knows(name) else None
        if encoding == "protobuf" and schema and schema.encoding == "protobuf":
            return ProtobufType(self._path, name, schema.data).decode
        return None


def open_log(path: Path) -> Log:
    """Reads the whole file, or all files of an archive.

    Raises:
        BadInput: it is damaged from its beginning, or mcap is missing.
    """
    return McapReader(path).read(archive_files(path) if path.is_dir() else (path,))


def _each(message: Any) -> Sequence[Any]:
    """The measurements of a message of our own form, which may hold many; any other message is one."""
    if not isinstance(message, Mapping):
        return (message,)
    t, value = message.get("t"), message.get("value")
    if not (isinstance(t, list) and isinstance(value, list) and len(t) == len(value)):
        return (message,)
    return [{"t": stamp, "value": each} for stamp, each in zip(t, value, strict=True)]
