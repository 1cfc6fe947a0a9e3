"""The file of a durable state: SQLite with a checksum on every row, so that what is read is what was written.

A rollback journal with full synchronisation: after kill -9 or a power cut the file holds all of an iteration or nothing
of it, and between two iterations a copy of this one file is the whole state. Each row of the history names the
revision before it, so that a row that is missing is noticed and not answered from an older one.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
import sqlite3
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from incsvr.errors import BadInput
from service.wire.json_text import json_text

_FORM = "%020d %08x\n"
_LENGTH = len(_FORM % (0, 0))


class StateLock:
    """The lock file beside a state, held until `close`; the system gives it back, even after kill -9.

    Its few bytes hold the highest revision that was published and could not be saved. They are written in place, which
    a full disk still allows, so that no revision is given to two models.

    Attributes:
        marked: a state has been written here before.
        published: that revision; 0 where all was saved.

    Raises:
        BadInput: another learner holds it.
        OSError: the file cannot be made.
    """

    def __init__(self, path: Path, state: Path) -> None:
        with ExitStack() as undone:
            try:
                self._file, self._writable = os.open(path, os.O_RDWR | os.O_CREAT, 0o644), True
            except OSError as error:
                if error.errno != errno.EROFS:
                    raise
                self._file, self._writable = os.open(path, os.O_RDONLY), False
            undone.callback(os.close, self._file)
            self._path, self._state = path, state
            self._lock(self._file)
            self._identity = _identity(os.fstat(self._file))
            found = _read(os.pread(self._file, _LENGTH, 0))
            self.marked, self.published = found is not None, found or 0
            undone.pop_all()

    @property
    def in_place(self) -> bool:
        """Whether the lock file still stands where it was: else another learner may take one of that name."""
        try:
            return _identity(self._path.stat()) == self._identity
        except OSError:
            return False

    def mark(self, published: int) -> None:
        """A state is here, and revisions up to this one are spent; on the disk when this returns.

        Raises:
            OSError: the disk does not take it.
        """
        if not self._writable:
            self._open_to_write()
        digits = b"%020d" % published
        os.pwrite(self._file, (_FORM % (published, zlib.crc32(digits))).encode(), 0)
        os.fsync(self._file)
        self.marked, self.published = True, published

    def close(self) -> None:
        os.close(self._file)

    def _open_to_write(self) -> None:
        """The lock that was taken on a read-only disk, taken again where the disk can be written now."""
        file = os.open(self._path, os.O_RDWR)
        try:
            fcntl.flock(self._file, fcntl.LOCK_UN)
            self._lock(file)
        except BaseException:
            os.close(file)
            raise
        os.close(self._file)
        self._file, self._writable = file, True

    def _lock(self, file: int) -> None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BadInput(f"another learner has the state {self._state}; end it, or name another directory") from None


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


def _read(content: bytes) -> int | None:
    digits = content[:20]
    if not digits.isdigit() or content != (_FORM % (int(digits), zlib.crc32(digits))).encode():
        return None
    return int(digits)


_TABLES = {
    "identity": "CREATE TABLE identity (name TEXT PRIMARY KEY, value TEXT NOT NULL, checksum BLOB NOT NULL)",
    "memory": "CREATE TABLE memory (only INTEGER PRIMARY KEY CHECK (only = 1), value TEXT NOT NULL,"
    " checksum BLOB NOT NULL)",
    "history": "CREATE TABLE history (revision INTEGER PRIMARY KEY, previous INTEGER NOT NULL, t REAL NOT NULL,"
    " snapshot BLOB NOT NULL, report BLOB NOT NULL, checksum BLOB NOT NULL)",
    "history_t": "CREATE INDEX history_t ON history (t)",
}
_DISK = frozenset(
    {
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_IOERR,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_NOMEM,
    }
)
"""Errors of SQLite that say nothing about what is in the file."""
READER_PATIENCE_S = 0.5
"""The time for which a reader from outside may hold up an iteration [s]; beyond, it is saved with the next."""


class StateDamage(Exception):
    """A file differs from what was written; the message names the sign."""


class Row(NamedTuple):
    """One published revision, with the one before it; t is the vehicle's time [s]."""

    revision: int
    previous: int
    t: float
    snapshot: bytes
    report: bytes


class StateFile:
    """An open state; from one thread at a time. A damaged one raises `StateDamage`, a disk that fails `sqlite3.Error`.

    Attributes:
        newest: the newest revision of the history; 0 where there is none.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with _telling_damage():
            if path.is_dir():
                raise StateDamage("a directory is in its place")
            self._identity = _file_identity(path)
            if path.stat().st_size == 0:
                raise StateDamage("it is empty, as a power cut can leave it")
            self._connection = _connect(path)
            try:
                found = dict(self._connection.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL"))
                if found != {name.encode(): sql.encode() for name, sql in _TABLES.items()}:
                    raise StateDamage("its tables are damaged or of another version")
                (newest,) = self._connection.execute("SELECT max(revision) FROM history").fetchone()
                self.newest: int = newest or 0
            except BaseException:
                self._connection.close()
                raise

    @staticmethod
    def create(path: Path, identity: Mapping[str, Any], known: StateFile | None = None) -> StateFile:
        """A new file in this place, there as a whole or not at all: empty, or with all that a `known` one holds."""
        fresh = path.with_name(path.name + ".new")
        for leftover in (fresh, fresh.with_name(fresh.name + "-journal")):
            leftover.unlink(missing_ok=True)
        with closing(_connect(fresh, "rwc")) as connection:
            if known is not None:
                with _telling_damage():
                    known._connection.backup(connection)
            else:
                with connection:  # one transaction: each waits for the disk twice
                    connection.execute("BEGIN")
                    for statement in _TABLES.values():
                        connection.execute(statement)
                    _write_identity(connection, identity)
                    _write_memory(connection, b"null")
        fresh.replace(path)
        _synchronise(path.parent)
        return StateFile(path)

    @property
    def in_place(self) -> bool:
        """Whether this file still stands where it was opened."""
        try:
            return _file_identity(self._path) == self._identity and self._path.stat().st_size > 0
        except OSError:
            return False

    def identity(self) -> dict[str, Any]:
        """The identity of the learner whose state it is."""
        with _telling_damage():
            rows = self._connection.execute("SELECT name, value, checksum FROM identity").fetchall()
            return {
                name.decode(): json.loads(_checked_value("identity", name, value, sum_)) for name, value, sum_ in rows
            }

    def memory(self) -> Any:
        """The learner's memory; None where nothing has been learned."""
        with _telling_damage():
            row = self._connection.execute("SELECT value, checksum FROM memory").fetchone()
            if row is None:
                raise StateDamage("its memory is missing")
            return json.loads(_checked_value("memory", *row))

    def write(self, memory: bytes, rows: Sequence[Row], keep: int, changed: Mapping[str, Any]) -> None:
        """Writes memory, revisions and parts of the identity in one transaction; all are on disk when it returns."""
        with _telling_damage(), self._connection as connection:
            _write_memory(connection, memory)
            _write_identity(connection, changed)
            for row in rows:
                values = (*row, _checksum("history", *row))
                connection.execute("INSERT OR REPLACE INTO history VALUES (?, ?, ?, ?, ?, ?)", values)
            newest = rows[-1].revision if rows else self.newest
            connection.execute("DELETE FROM history WHERE revision <= ?", (newest - keep,))
        self.newest = newest

    def row(self, revision: int) -> Row | None:
        """The row of a revision."""
        return self._one("WHERE revision = ?", revision)

    def at(self, t: float) -> tuple[Row | None, Row | None]:
        """The newest row that is not younger than the vehicle's time t [s], and the one after it."""
        with _telling_damage():
            (revision,) = self._connection.execute("SELECT max(revision) FROM history WHERE t <= ?", (t,)).fetchone()
        if revision is None:
            return None, None
        found, following = self.row(revision), self._one("WHERE revision > ? ORDER BY revision LIMIT 1", revision)
        if found is None or found.t > t or (following is not None and following.t <= t):
            raise StateDamage("its index of times is damaged")
        return found, following

    def revisions(self, after: int, limit: int) -> list[int]:
        """The next revisions of the history after this one, at most `limit`, in their order."""
        with _telling_damage():
            query = "SELECT revision FROM history WHERE revision > ? ORDER BY revision LIMIT ?"
            return [revision for (revision,) in self._connection.execute(query, (after, limit))]

    def close(self) -> None:
        self._connection.close()

    def _one(self, where: str, value: int) -> Row | None:
        with _telling_damage():
            query = f"SELECT revision, previous, t, snapshot, report, checksum FROM history {where}"
            found = self._connection.execute(query, (value,)).fetchone()
            if found is None:
                return None
            _checked_value("history", *found)
            return Row(*found[:-1])


def _connect(path: Path, mode: str = "rw") -> sqlite3.Connection:
    uri = f"file:{quote(str(path))}?mode={mode}"
    connection = sqlite3.connect(uri, uri=True, check_same_thread=False, timeout=READER_PATIENCE_S)
    connection.text_factory = bytes  # a flipped bit may make it no UTF-8
    try:
        connection.execute("PRAGMA journal_mode = TRUNCATE")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA cell_size_check = ON")
        connection.execute("PRAGMA cache_size = -256")  # kB: the history is written far more than read
    except BaseException:
        connection.close()
        raise
    return connection


def _write_identity(connection: sqlite3.Connection, identity: Mapping[str, Any]) -> None:
    for name, content in identity.items():
        value = json_text(content).encode()
        row = (name, value, _checksum("identity", name.encode(), value))
        connection.execute("INSERT OR REPLACE INTO identity VALUES (?, ?, ?)", row)


def _write_memory(connection: sqlite3.Connection, memory: bytes) -> None:
    connection.execute("INSERT OR REPLACE INTO memory VALUES (1, ?, ?)", (memory, _checksum("memory", memory)))


def _checksum(table: str, *values: object) -> bytes:
    return hashlib.blake2b(repr((table, *values)).encode(), digest_size=8).digest()


def _checked_value(table: str, *row: Any) -> Any:
    """The last value before the checksum, which closes the row."""
    *values, checksum = row
    if _checksum(table, *values) != checksum:
        raise StateDamage(f"a row of its {table} does not fit its checksum")
    return values[-1]


@contextmanager
def _telling_damage() -> Iterator[None]:
    """Makes `StateDamage` of what a damaged file raises; what the disk raises passes."""
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT)
        if code & 0xFF in _DISK and code != sqlite3.SQLITE_IOERR_SHORT_READ:
            raise
        raise StateDamage(f"it is damaged ({error})") from error
    except (ValueError, TypeError, AttributeError) as error:
        raise StateDamage(f"it is damaged ({error})") from error


def _file_identity(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_dev, status.st_ino


def _synchronise(directory: Path) -> None:
    """Synchronises a directory, so that a renamed file is on the disk."""
    descriptor = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
