"""Bags of ROS 1 (.bag) and ROS 2 (a folder, or its .db3), read by rosbags."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.forms import cdr
from service.inputs.senders import SENDER
from service.inputs.table import Topic
from service.logs.log import Damage, Log, TableBuilder, first_line
from service.logs.opening import first_bytes


def open_log(path: Path) -> Log:
    """Reads the whole bag.

    Raises:
        BadInput: it is damaged, or rosbags is missing.
    """
    one = not path.is_dir() and first_bytes(path).startswith(b"#ROSBAG")
    types, damage = RosTypes(path, one), Damage(path)
    with _opened(path, one) as reader:
        connections = sorted(reader.connections, key=lambda each: str(each.topic))
        for each in connections:
            if each.msgdef.data:
                types.define(each.msgtype, each.msgdef.data, "IDL" in str(each.msgdef.format))
        known = [each for each in connections if types.knows(each.msgtype)]
        gathered = _gathered(reader, known, types, damage)
        counts, kinds = Counter[str](), dict[str, str]()
        for each in connections:  # several senders of one name are one topic
            counts[each.topic] += each.msgcount
            kinds[each.topic] = each.msgtype
    fields = {name: tuple(field for field in found.fields if field != SENDER) for name, found in gathered.items()}
    topics = (Topic(name, kind, fields.get(name, ()), counts[name]) for name, kind in kinds.items())
    tables = {name: found.table() for name, found in gathered.items() if len(found)}
    return Log("ROS 1 bag" if one else "ROS 2 bag", tuple(topics), tables, damage.notes, damage.broken)


def _gathered(reader: Any, known: Sequence[Any], types: RosTypes, damage: Damage) -> dict[str, TableBuilder]:
    """The messages of connections whose types are known; of several senders of one name each says whose it is."""
    several = Counter(each.topic for each in reader.connections)
    found = {each.topic: TableBuilder() for each in known}
    for connection, stamp, payload in reader.messages(connections=known) if known else ():
        try:
            message = types.decode(payload, connection.msgtype)
        except Exception as error:  # bytes that end early raise whatever reads them
            damage.add_broken(connection.topic, error)
            continue
        damage.add_read(connection.topic)
        if several[connection.topic] > 1:
            message[SENDER] = connection.id
        found[connection.topic].add(stamp * 1e-9, message)
    return found


@contextmanager
def _opened(path: Path, one: bool) -> Iterator[Any]:
    try:
        if one:
            reader = load_package("rosbags.rosbag1", path, "a bag").Reader(path)
        elif path.is_dir():
            reader = load_package("rosbags.rosbag2", path, "a bag").Reader(path)
        else:
            reader = load_package("rosbags.rosbag2.storage_sqlite3", path, "a bag").Sqlite3Reader(path)
        reader.open()
    except BadInput:
        raise
    except Exception as error:  # rosbags raises what its databases and parsers do, too
        raise BadInput(
            f"{path}: cannot be read as a bag ({first_line(error)}); reindex it, or record it again"
        ) from None
    try:
        yield reader
    finally:
        reader.close()


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
        """Whether messages of the type are read: pictures and clouds hold bytes, are most of a log, and are not."""
        found = self._store.fielddefs.get(full_name(name))
        return found is not None and not any(_holds_bytes(*field) for field in found[1])

    def decode(self, payload: bytes, name: str) -> dict[str, Any]:
        """The fields of a message, nested; stamps and durations as seconds."""
        read = self._store.deserialize_ros1 if self._one else self._store.deserialize_cdr
        return dict(_fields(read(payload, full_name(name))))


def _holds_bytes(name: str, kind: tuple[Any, Any]) -> bool:
    """Whether a field is the `data` of a picture or a cloud: bytes, as many as there are."""
    node, of = kind
    return name == "data" and node.name == "SEQUENCE" and of[0][1][0] in ("uint8", "byte", "octet")


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
    return cdr.with_yaw(found) if message.__msgtype__ == cdr.QUATERNION else found


def _plain(value: Any) -> Any:
    if hasattr(value, "nanosec"):
        return value.sec + value.nanosec * 1e-9
    if hasattr(value, "__dataclass_fields__"):
        return _fields(value)
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value
