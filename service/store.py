"""What survives a crash: the learner's memory after each iteration and the history of what it published.

SQLite with a write-ahead log and full synchronisation: after kill -9 or a power cut the file holds either all of an
iteration or nothing of it. One file for each learner. A state that belongs to another version, vehicle or setting is
refused aloud and set aside under another name, never half-read.
"""

from __future__ import annotations

import fcntl
import json
import logging
import sqlite3
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

from incsvr.errors import BadInput
from incsvr.learning import learner
from service.config import Config

log = logging.getLogger(__name__)

FORM = 1  # of the tables and of what is in them
_TABLES = """
CREATE TABLE IF NOT EXISTS identity (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS memory (only INTEGER PRIMARY KEY CHECK (only = 1), value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS history (
    revision INTEGER PRIMARY KEY, t REAL NOT NULL, snapshot BLOB NOT NULL, report BLOB NOT NULL);
"""


def identity(config: Config, effects: str | None = None) -> dict[str, Any]:
    """What a state must agree with to be taken up; `effects` names the traced effects that samples are freed of."""
    settings = config.learner
    return {
        "form": [FORM, learner.FORM],
        "vehicle": config.vehicle.name,
        "prefix": config.prefix,
        "inertia": config.vehicle.inertia,
        "policy": settings.policy,
        "gamma": settings.gamma,
        "C": settings.C,
        "epsilon": settings.epsilon,
        "bins": settings.bins,
        "effects": effects,
    }


class Store:
    """The durable state of one learner.

    Args:
        directory: where its file is.
        config: whose it is.
        effects: names the traced effects that samples are freed of.
        changing: the effects may change while it learns: then the memory says under `effects` which they are.

    Attributes:
        refusal: why an earlier state was set aside, as one sentence; None where it was not.
        memory: the learner's memory as it was last saved; None where it begins anew.

    Raises:
        BadInput: the directory cannot be written, or another learner has this state.
    """

    def __init__(self, directory: Path, config: Config, effects: str | None = None, changing: bool = False) -> None:
        self.path = directory / (config.prefix + ".sqlite")
        self._changing = changing
        self.refusal: str | None = None
        self.memory: dict[str, Any] | None = None
        self._keep = config.history
        self._lock = threading.Lock()
        with ExitStack() as undone:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._mine = undone.enter_context(self.path.with_suffix(".lock").open("w"))
                _take(self._mine, self.path)
                self._write, self.memory = self._open(identity(config, effects))
                self._read = self._connect()
            except (OSError, sqlite3.OperationalError) as error:
                raise BadInput(f"the state cannot be kept in {directory} ({error}); name another directory") from error
            undone.pop_all()

    def save(self, memory: Mapping[str, Any], revision: int, t: float, snapshot: bytes, report: bytes) -> None:
        """Saves one iteration as a whole; when this returns it is on the disk."""
        with self._write:
            self._remember(memory)
            self._write.execute("INSERT OR REPLACE INTO history VALUES (?, ?, ?, ?)", (revision, t, snapshot, report))
            self._write.execute("DELETE FROM history WHERE revision <= ?", (revision - self._keep,))

    def save_memory(self, memory: Mapping[str, Any]) -> None:
        """Saves the memory alone: what is on its way to the next batch at the end, or a step of tracing."""
        with self._write:
            self._remember(memory)

    def at(self, t: float) -> bytes | None:
        """The snapshot that was served at the vehicle's time t [s]: the newest that is not younger."""
        return self._one("SELECT snapshot FROM history WHERE t <= ? ORDER BY revision DESC LIMIT 1", t)

    def revision(self, revision: int) -> bytes | None:
        """The snapshot of a revision."""
        return self._one("SELECT snapshot FROM history WHERE revision = ?", revision)

    def latest_report(self) -> bytes | None:
        """The newest iteration report."""
        return self._one("SELECT report FROM history WHERE revision > ? ORDER BY revision DESC LIMIT 1", -1)

    def reports(self, after: int, limit: int) -> list[bytes]:
        """At most `limit` iteration reports after a revision, in their order."""
        with self._lock:
            rows = self._read.execute(
                "SELECT report FROM history WHERE revision > ? ORDER BY revision LIMIT ?", (after, limit)
            )
            return [row[0] for row in rows]

    def close(self) -> None:
        with self._lock:
            self._read.close()
        self._write.close()
        self._mine.close()

    def _remember(self, memory: Mapping[str, Any]) -> None:
        self._write.execute("INSERT OR REPLACE INTO memory VALUES (1, ?)", (json.dumps(memory),))
        if self._changing:
            effects = json.dumps(memory.get("effects"))
            self._write.execute("INSERT OR REPLACE INTO identity VALUES ('effects', ?)", (effects,))

    def _one(self, query: str, value: float) -> bytes | None:
        with self._lock:
            row = self._read.execute(query, (value,)).fetchone()
        return None if row is None else row[0]

    def _open(self, own: Mapping[str, Any]) -> tuple[sqlite3.Connection, dict[str, Any] | None]:
        """The connection to write with, and the memory found; a file that does not fit is set aside first."""
        reason = None
        if self.path.exists():
            try:
                return self._found(own)
            except BadInput as error:
                reason = str(error)
            except (sqlite3.DatabaseError, ValueError) as error:
                if isinstance(error, sqlite3.OperationalError):
                    raise
                reason = f"it is damaged ({error})"
        if reason is not None:
            aside = self._set_aside()
            self.refusal = f"the state {self.path} was set aside as {aside.name}: {reason}"
            log.error("%s", self.refusal)
        connection = self._connect()
        connection.executescript(_TABLES)
        _write_identity(connection, own)
        return connection, None

    def _found(self, own: Mapping[str, Any]) -> tuple[sqlite3.Connection, dict[str, Any] | None]:
        connection = self._connect()
        try:
            connection.executescript(_TABLES)
            kept = {name: json.loads(value) for name, value in connection.execute("SELECT name, value FROM identity")}
            row = connection.execute("SELECT value FROM memory").fetchone()
            memory = None if row is None else json.loads(row[0])
            if self._changing and memory is not None:
                own = {**own, "effects": memory.get("effects")}
            different = [name for name in own if kept.get(name) != own[name]]
            if kept and different:
                name = different[0]
                raise BadInput(f"it was learned with {name} {kept.get(name)}, and now {name} is {own[name]}")
            if not kept and row is not None:
                raise BadInput("it does not say whose it is")
            connection.executemany(
                "INSERT OR REPLACE INTO identity VALUES (?, ?)", [(n, json.dumps(own[n])) for n in own]
            )
            connection.commit()
            return connection, memory
        except BaseException:
            connection.close()
            raise

    def _connect(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self.path, check_same_thread=False, timeout=2.0)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA cache_size = -256")  # kB: the history is written far more than read
        return connection

    def _set_aside(self) -> Path:
        """Renames the file and what SQLite keeps beside it, to the first name that is free."""
        number = 1
        while (aside := self.path.with_name(f"{self.path.stem}.refused-{number}.sqlite")).exists():
            number += 1
        for suffix in ("", "-wal", "-shm"):
            beside = self.path.with_name(self.path.name + suffix)
            if beside.exists():
                beside.rename(aside.with_name(aside.name + suffix))
        return aside


def _take(lock: IO[str], path: Path) -> None:
    """Two learners would write over each other's iterations. The system gives the lock back, even after kill -9."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BadInput(f"another learner has the state {path}; end it, or name another directory") from None


def _write_identity(connection: sqlite3.Connection, own: Mapping[str, Any]) -> None:
    with connection:
        connection.executemany(
            "INSERT OR REPLACE INTO identity VALUES (?, ?)", [(name, json.dumps(own[name])) for name in own]
        )
