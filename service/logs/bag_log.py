"""Bags of ROS 1 (.bag) and ROS 2 (a folder, or its .db3), read by rosbags."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.senders import SENDER
from service.inputs.table import Table, Topic
from service.logs.log import Damage, TableBuilder, first_line
from service.logs.opening import first_bytes


class BagLog:
    """A bag; its messages are decoded where they are asked for."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._one = not path.is_dir() and first_bytes(path).startswith(b"#ROSBAG")
        self.format = "ROS 1 bag" if self._one else "ROS 2 bag"
        self._types, self._damage = RosTypes(path, self._one), Damage(path)
        with self._opened() as reader:
            for connection in reader.connections:
                if connection.msgdef.data:
                    self._types.define(
                        connection.msgtype, connection.msgdef.data, "IDL" in str(connection.msgdef.format)
                    )
            topics = [self._topic(reader, each) for each in sorted(reader.connections, key=_topic_name)]
            counts = Counter[str]()
            for each in topics:
                counts[each.name] += each.count
            named = {each.name: each for each in topics}  # several senders of one name are one topic
            self.topics = tuple(replace(each, count=counts[name]) for name, each in named.items())

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        gathered = {name: TableBuilder() for name in names}
        self._damage.begin(set(names))
        with self._opened() as reader:
            several = Counter(each.topic for each in reader.connections)
            wanted = [each for each in reader.connections if each.topic in names and self._types.knows(each.msgtype)]
            for connection, stamp, payload in reader.messages(connections=wanted) if wanted else ():
                try:
                    message = self._types.decode(payload, connection.msgtype)
                except Exception as error:  # bytes that end early raise whatever reads them
                    self._damage.add_broken(connection.topic, error)
                    continue
                self._damage.add_read(connection.topic)
                if several[connection.topic] > 1 and isinstance(message, dict):
                    message = {**message, SENDER: connection.id}
                gathered[connection.topic].add(stamp * 1e-9, message)
        self._damage.refuse()
        return {name: messages.table() for name, messages in gathered.items() if len(messages)}

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on messages that could not be read."""
        return self._damage.notes

    def _topic(self, reader: Any, connection: Any) -> Topic:
        fields: tuple[str, ...] = ()
        if self._types.knows(connection.msgtype):
            for _, stamp, payload in reader.messages(connections=[connection]):
                first = TableBuilder()
                try:
                    first.add(stamp * 1e-9, self._types.decode(payload, connection.msgtype))
                except Exception:  # the next one shows the fields; broken ones are counted where all are read
                    continue
                fields = first.fields
                break
        return Topic(connection.topic, connection.msgtype, fields, connection.msgcount)

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        try:
            if self._one:
                reader = load_package("rosbags.rosbag1", self._path, "a bag").Reader(self._path)
            elif self._path.is_dir():
                reader = load_package("rosbags.rosbag2", self._path, "a bag").Reader(self._path)
            else:
                reader = load_package("rosbags.rosbag2.storage_sqlite3", self._path, "a bag").Sqlite3Reader(self._path)
            reader.open()
        except BadInput:
            raise
        except Exception as error:  # rosbags raises what its databases and parsers do, too
            raise BadInput(
                f"{self._path}: cannot be read as a bag ({first_line(error)}); reindex it, or record it again"
            ) from None
        try:
            yield reader
        finally:
            reader.close()


def open_log(path: Path) -> BagLog:
    """Reads what is in a bag, and of each topic the first message.

    Raises:
        BadInput: it is damaged, or rosbags is missing.
    """
    return BagLog(path)


def _topic_name(connection: Any) -> str:
    return str(connection.topic)


class RosTypes:
    """The types of messages that are known: those of common packages, and those that a log defines itself."""

    def __init__(self, path: Path | str, one: bool = False) -> None:
        self._typesys = load_package("rosbags.typesys", path, "a message of ROS")
        stores = self._typesys.Stores
        self._store = self._typesys.get_typestore(stores.ROS1_NOETIC if one else stores.ROS2_JAZZY)
        self._one = one

    def define(self, name: str, text: str, idl: bool = False) -> None:
        """A type by the text of its definition, as MCAP files and bags hold it."""
        typesys = self._typesys
        types = typesys.get_types_from_idl(text) if idl else typesys.get_types_from_msg(text, full_name(name))
        self._store.register({each: fields for each, fields in types.items() if each not in self._store.fielddefs})

    def knows(self, name: str) -> bool:
        return full_name(name) in self._store.fielddefs

    def decode(self, payload: bytes, name: str) -> dict[str, Any]:
        """The fields of a message, nested; stamps and durations as seconds."""
        read = self._store.deserialize_ros1 if self._one else self._store.deserialize_cdr
        return dict(_fields(read(payload, full_name(name))))


def full_name(name: str) -> str:
    """`sensor_msgs/msg/Imu` for the `sensor_msgs/Imu` of ROS 1."""
    package, _, rest = name.partition("/")
    return name if rest.startswith(("msg/", "srv/", "action/")) else f"{package}/msg/{rest}"


def _fields(message: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in message.__dataclass_fields__:
        if name == "__msgtype__":
            continue
        found[name] = _plain(getattr(message, name))
    return found


def _plain(value: Any) -> Any:
    if hasattr(value, "nanosec"):
        return value.sec + value.nanosec * 1e-9
    if hasattr(value, "__dataclass_fields__"):
        return _fields(value)
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value
