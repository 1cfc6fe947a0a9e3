"""The reader of a log, by its first bytes."""

from __future__ import annotations

import gzip
import re
from importlib import import_module
from pathlib import Path
from typing import cast

from incsvr.errors import BadInput
from service.logs.log import Log

HEAD_BYTES = 320
"""Bytes from which a format is told; a packet of MAVLink with its stamp, and the next one's, are within them."""
GZIP = b"\x1f\x8b"
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
"""How text of two bytes a character begins, as spreadsheets write it."""
ZSTD = b"\x28\xb5\x2f\xfd"
_MAGIC = (
    (b"\x89MCAP0\r\n", "mcap_log"),
    (b"#ROSBAG V2.0", "bag_log"),
    (b"SQLite format 3\0", "bag_log"),
    (b"ULog\x01\x12\x35", "ulog_log"),
    (b"PAR1", "parquet_log"),
    (b"\xa3\x95", "dataflash_log"),
)
MIN_PACKET_BYTES = 8
"""Bytes of the shortest packet of MAVLink."""
_YEARS = (9.4e14, 4.1e15)
"""Microseconds since 1970 that a telemetry log may bear: from 2000 to 2099, or before where the clock was not set."""
STAMP_BYTES = 8
"""Bytes of the time of arrival before each packet: µs since 1970, big-endian."""


def open_any(path: Path) -> Log:
    """The log in a file, or in the folder of a bag or an archive.

    Raises:
        BadInput: there is no such file, or nothing that is read here.
    """
    return cast(Log, import_module(f"service.logs.{reader(path)}").open_log(path))


def reader(path: Path) -> str:
    """The name of the module that reads `path`."""
    if path.is_dir():
        if (path / "metadata.yaml").is_file():
            return "bag_log"
        if archive_files(path):
            return "mcap_log"
        raise BadInput(
            f"{path}: this folder cannot be read as a log; give a file, or the folder of a ROS 2 bag or of an "
            "archive of `serve`"
        )
    head = first_bytes(path)
    for magic, module in _MAGIC:
        if head.startswith(magic):
            return module
    if _is_telemetry(head):
        return "telemetry_log"
    if head.startswith(ZSTD):
        raise BadInput(
            f"{path}: it is compressed with zstd; give the folder of its bag, with the metadata.yaml, or unpack it "
            "with `zstd -d`"
        )
    text = _inflated(path) if head.startswith(GZIP) else head
    if b"\0" in text and not _is_utf_16(text):
        raise BadInput(
            f"{path}: no format that is read here (CSV, Parquet, MCAP, ROS bag, ArduPilot .BIN and .tlog, PX4 .ulg); "
            "export it as CSV"
        )
    return "csv_log"


def _is_utf_16(text: bytes) -> bool:
    """Whether the first bytes of a file are a table's text of two bytes a character."""
    return text.startswith(UTF_16) and any(mark in text.decode("utf-16", errors="ignore") for mark in ",;\t|\n")


def is_log(path: Path) -> bool:
    """Whether a file or folder is a log; text is one where its name says that it is a table."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file() or bool(archive_files(path))
    try:
        found = reader(path)
    except BadInput:
        return False
    return found != "csv_log" or bool({".csv", ".tsv"} & set(path.suffixes))


def first_bytes(path: Path) -> bytes:
    """The first bytes of a file."""
    try:
        with path.open("rb") as file:
            return file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; give the path of a recording") from None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); give the path of a recording") from None


def _inflated(path: Path) -> bytes:
    try:
        with gzip.open(path) as file:
            return file.read(HEAD_BYTES)
    except (OSError, EOFError):
        return b"\0"


def _is_telemetry(head: bytes) -> bool:
    size, stamp = packet_size(head[STAMP_BYTES:]), int.from_bytes(head[:STAMP_BYTES], "big")
    following = head[STAMP_BYTES + size + STAMP_BYTES :][:1]
    return size > 0 and stamp < _YEARS[1] and (stamp > _YEARS[0] or following in (b"\xfe", b"\xfd"))


def packet_size(header: bytes) -> int:
    """Bytes of the MAVLink packet, version 1 or 2, that begins with these; 0 where none does."""
    if len(header) < MIN_PACKET_BYTES:
        return 0
    first, length, flags = header[0], header[1], header[2]
    signature = 13 if flags & 1 else 0
    return {0xFE: 8 + length, 0xFD: 12 + length + signature}.get(first, 0)


ARCHIVE_PROFILE = "incsvr"
"""The profile of the files: by it `replay` knows that they hold what came, as it came."""
METADATA_NAME = "incsvr"
"""The name of the metadata that every file begins with."""
JSON_ENCODING = "json"
"""The encoding of what is JSON, as MCAP calls it."""


def archive_files(directory: Path, name: str = "") -> list[Path]:
    """The files of an archive, the oldest first; `name` is the learner's `Keys.file_name`, empty for all."""
    pattern = re.compile(rf"{re.escape(name) if name else '.+'}_\d{{6,}}\.mcap")
    return sorted((path for path in directory.glob("*.mcap") if pattern.fullmatch(path.name)), key=number)


def number(path: Path) -> int:
    """The place of a file among those of its archive."""
    return int(path.stem.rpartition("_")[2])
