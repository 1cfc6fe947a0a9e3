"""The archive of all messages in MCAP files of bounded size: `incsvr serve --archive DIR`.

Messages are written as they came, byte for byte and in the order in which the learner took them: what it lost before is
not in them, so that `incsvr replay DIR` brings a learner that begins anew to the same models. A thread of its own
writes, so that a slow disk or a full one stops nothing else.

    leng-yaw_000017.mcap    the oldest go where more than `most_bytes` would be kept
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.config.configuration import Config
from service.logs.opening import ARCHIVE_PROFILE, JSON_ENCODING, METADATA_NAME, archive_files, number
from service.state.disk_refusals import OTHER_ARCHIVE, may_pass, refusal
from service.wire import Keys
from service.wire.json_text import json_text

log = logging.getLogger(__name__)

WRITE_PERIOD_S = 0.5
"""The period at which waiting messages are written [s]."""
FILE_BYTES = 32_000_000
"""The largest size of a file [bytes], unless all files together may be less than two of it."""
CHUNK_BYTES = 65_536
"""Size of the parts that are compressed and written [bytes]: a kill -9 loses the last one."""
QUEUE_BYTES = 8_000_000
"""The largest queue [bytes]; messages beyond it are not archived, but counted."""
MESSAGE_BYTES = 300
"""The memory of a waiting message beside its payload [bytes]."""
RETRY_S = 5.0
"""After a disk took nothing, it is tried again so much later [s]."""
MAX_OVERSHOOT_BYTES = 1_100_000
"""The largest excess of a file over its size [bytes]: a chunk that one large message fills alone."""


@dataclass(frozen=True, slots=True)
class _Message:
    key: str
    encoding: str
    payload: bytes
    at: int  # ns since 1970


class Archive:
    """The archive of one learner; `came` and `went` may be called from any thread and never wait for the disk.

    Args:
        directory: where the files are; made where it is missing.
        prefix: of the learner's keys.
        about: texts that every file begins with, such as the configuration.
        file_bytes: a file of this size is finished, and another one begun.
        most_bytes: the files of this learner together are no larger.

    Raises:
        BadInput: the directory cannot be written, or the package mcap is missing. A full disk is no reason.
    """

    def __init__(
        self, directory: Path, prefix: str, about: Mapping[str, str], *, file_bytes: int, most_bytes: int
    ) -> None:
        self._writing = load_package("mcap.writer", directory, "an archive")
        self._directory, self._name, self._prefix = directory, Keys(prefix).file_name, prefix
        self._about = dict(about)
        self._file_bytes, self._most_bytes = file_bytes, most_bytes
        self._waiting: deque[_Message] = deque()
        self._lock = threading.Lock()
        self._bytes = self._lost = 0
        self._problem: str | None = None
        self._retry = 0.0
        self._removed = ""
        self._number = 0  # of the newest file
        self._path = directory
        self._file: _Appended | None = None
        self._writer: Any = None
        self._channels: dict[tuple[str, str], int] = {}
        self._numbers: dict[int, int] = {}
        try:
            self._begin()
        except OSError as error:
            if not may_pass(error):
                why_not = refusal(error, directory, OTHER_ARCHIVE)
                raise BadInput(f"nothing can be archived in {directory}: {why_not}") from error
            self._fails(error)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._work, name=f"archive of {prefix}", daemon=True)
        self._thread.start()

    def came(self, key: str, encoding: str, payload: bytes, arrival: float | None = None) -> None:
        """A message was taken in; `encoding` is that of the bus, `arrival` when it came [s], if not now."""
        self._put(key, JSON_ENCODING if encoding in _JSON else encoding, payload, arrival)

    def went(self, key: str, payload: bytes) -> None:
        """Archives a message that was published, as JSON."""
        self._put(key, JSON_ENCODING, payload)

    def notices(self) -> tuple[str, ...]:
        """Sentences on messages that are not archived, with the reason."""
        if self._problem is not None:
            return (f"messages are not archived: {self._problem}",)
        missing = f"{self._lost} messages are missing in the archive" if self._lost else ""
        return tuple(sentence for sentence in (self._removed, missing) if sentence)

    def close(self) -> None:
        """Writes what waits and finishes the file."""
        self._stop.set()
        self._thread.join()

    def _put(self, key: str, encoding: str, payload: bytes, arrival: float | None = None) -> None:
        at = time.time_ns() if arrival is None else int(arrival * 1e9)
        size = len(payload) + MESSAGE_BYTES
        with self._lock:
            if self._problem is not None or self._bytes + size > QUEUE_BYTES:
                self._lost += 1
                return
            self._bytes += size
            self._waiting.append(_Message(key, encoding, payload, at))

    def _work(self) -> None:
        while not self._stop.wait(WRITE_PERIOD_S):
            self._write()
        self._write()
        self._finish()

    def _write(self) -> None:
        """Writes what waits; where the disk takes nothing, what waits is dropped and counted."""
        try:
            if self._file is not None and not self._in_place(self._file):
                self._replace()
            if self._writer is None:
                if time.monotonic() < self._retry:
                    return
                self._begin()
            while self._waiting:
                with self._lock:
                    message = self._waiting.popleft()
                    self._bytes -= len(message.payload) + MESSAGE_BYTES
                self._add(message)
            if self._file is not None:
                self._file.flush()
        except OSError as error:
            self._fails(error)

    def _in_place(self, file: _Appended) -> bool:
        """Whether the file, flushed, still has its name and all that was written to it."""
        try:
            found, own = self._path.stat(), os.fstat(file.fileno())
        except FileNotFoundError:
            return False
        return (found.st_dev, found.st_ino) == (own.st_dev, own.st_ino) and found.st_size == file.written

    def _replace(self) -> None:
        """Begins another file, because the one that was written is gone, with its messages."""
        count = sum(self._numbers.values())
        self._removed = (
            f"the archive's file {self._path} was removed, renamed or cut while it was written, with {count} messages; "
            "another one was begun"
        )
        log.error("%s: %s", self._prefix, self._removed)
        self._lost += count
        self._finish()  # where it was only renamed, it is whole under its new name
        self._begin()

    def _add(self, message: _Message) -> None:
        if self._file is not None and self._file.tell() >= self._file_bytes:
            self._finish()
            self._begin()
        known = (message.key, message.encoding)
        if known not in self._channels:
            self._channels[known] = self._writer.register_channel(*known, schema_id=0)
        channel = self._channels[known]
        self._numbers[channel] = self._numbers.get(channel, 0) + 1
        self._writer.add_message(channel, message.at, message.payload, message.at, self._numbers[channel])

    def _begin(self) -> None:
        """Begins another file, after deleting the oldest to make room."""
        self._directory.mkdir(parents=True, exist_ok=True)
        files = archive_files(self._directory, self._name)
        sizes, newest = [path.lstat().st_size for path in files], number(files[-1]) if files else 0
        self._number = max(newest, self._number) + 1
        while files and sum(sizes) + self._file_bytes + MAX_OVERSHOOT_BYTES > self._most_bytes:
            files.pop(0).unlink()
            sizes.pop(0)
        path = self._directory / f"{self._name}_{self._number:06d}.mcap"
        file = _Appended(path)
        try:
            writer = self._writing.Writer(file, chunk_size=CHUNK_BYTES)
            writer.start(profile=ARCHIVE_PROFILE, library=f"incsvr, archive of {self._prefix}")
            writer.add_metadata(
                METADATA_NAME, {"prefix": self._prefix, "missing_before": str(self._lost), **self._about}
            )
            file.flush()
        except OSError:
            with contextlib.suppress(OSError):
                file.close()
            path.unlink()
            raise
        self._file, self._writer, self._problem = file, writer, None
        self._path = path
        self._channels.clear()
        self._numbers.clear()

    def _finish(self) -> None:
        file, writer, self._file, self._writer = self._file, self._writer, None, None
        if file is None:
            return
        try:
            writer.finish()
        except OSError as error:
            self._fails(error)
        finally:
            with contextlib.suppress(OSError):
                file.close()

    def _fails(self, error: OSError) -> None:
        """The disk takes nothing now."""
        first, problem = self._problem is None, refusal(error, self._directory, OTHER_ARCHIVE)
        if first:
            log.error("%s: messages are not archived: %s", self._prefix, problem)
        with self._lock:
            self._problem = problem
            self._lost += len(self._waiting)
            self._waiting.clear()
            self._bytes = 0
        self._retry = time.monotonic() + RETRY_S
        file, self._file, self._writer = self._file, None, None
        if file is not None:
            with contextlib.suppress(OSError):
                file.close()


class _Appended(io.BufferedWriter):
    """A new file that is written at its end wherever that is: one that was cut is shorter then than what was written.

    Attributes:
        written: so many bytes.
    """

    def __init__(self, path: Path) -> None:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, 0o644)
        super().__init__(io.FileIO(number, "wb"))
        self.written = 0

    def write(self, part: Any) -> int:
        self.written += memoryview(part).nbytes
        return super().write(part)


_JSON = {"application/json", "text/json"}


def about(config_json: Mapping[str, Any], boot: str) -> dict[str, str]:
    """The learner's record at the head of a file: the start of the process, and its configuration."""
    return {"boot": boot, "config": json_text(config_json)}


def archive_of(config: Config, boot: str, learners: int) -> Archive | None:
    """The archive of a configuration; None if it has none."""
    archive = config.archive
    if archive.directory is None:
        return None
    told, most = (
        about(config.model_dump(mode="json", exclude={"learners"}), boot),
        1_000_000 * archive.most_mb // learners,
    )
    size = min(FILE_BYTES, most // 2)
    return Archive(archive.directory, config.prefix, told, file_bytes=size, most_bytes=most)
