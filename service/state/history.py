"""The history of published revisions: the rows of a state's file, and the newest that wait for the disk.

A learner without a state has its newest ones all the same, as long as it runs: a client on a busy machine asks for the
model of an iteration when the next has often been published.
"""

from __future__ import annotations

import logging
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from incsvr.errors import BadInput
from service.state.state_file import Row, StateDamage, StateFile

log = logging.getLogger(__name__)

WAITING_BYTES = 16_000_000
"""Revisions that wait for the disk; beyond, the oldest go. A thousand of them fit."""
IN_MEMORY_BYTES = 1_000_000
"""Revisions that a learner without a state keeps all the time. Fifty fit: half an hour of batches."""


class NotKept(BadInput):
    """The history does not reach there, or what is there is damaged."""


class History:
    """Answers for revisions; every method may be called from any thread.

    Args:
        keep: how many the file holds at most.
        waiting_bytes: of those that wait for it; beyond, the oldest go.

    Attributes:
        file: where it is kept; None where there is none yet.
        published: the highest revision that is known to be given, saved or not.
        newest: what was published last since the start.
        damage: what was found damaged, as sentences.
        lost: the first and the last revision of each gap: published, and never on the disk.
        lock: held by every method; and by who changes the file.
    """

    def __init__(self, keep: int, waiting_bytes: int = WAITING_BYTES) -> None:
        self._keep, self._waiting_bytes = keep, waiting_bytes
        self.lock = threading.RLock()
        self.file: StateFile | None = None
        self.published = 0
        self.newest: Row | None = None
        self.damage: tuple[str, ...] = ()
        self.lost: tuple[tuple[int, int], ...] = ()
        self._lost_now = 0  # gaps at the end of `lost` that this start found
        self._waiting: dict[int, Row] = {}

    def add(self, revision: int, t: float, snapshot: bytes, report: bytes) -> None:
        """A revision that is published next, and waits for the disk."""
        with self.lock:
            self.newest = Row(revision, self.published, float(t), snapshot, report)
            self._waiting[revision], self.published = self.newest, revision
            while len(self._waiting) > 1 and sum(map(_size, self._waiting.values())) > self._waiting_bytes:
                oldest = min(self._waiting)
                del self._waiting[oldest]
                if self.file is not None or self._keep:
                    self.lose(oldest, oldest)

    def remember(self, lost: tuple[tuple[int, int], ...]) -> None:
        """The gaps that earlier starts found."""
        with self.lock:
            self.lost, self._lost_now = lost, 0

    def lose(self, first: int, last: int) -> None:
        """The disk did not take these revisions, and nobody has them any more."""
        with self.lock:
            before = self.lost[-1] if self._lost_now else None
            if before is not None and before[0] <= first <= before[1] + 1:
                self.lost = (*self.lost[:-1], (before[0], max(last, before[1])))
                return
            self.lost = (*self.lost, (first, last))[-MAX_GAPS:]
            self._lost_now = min(self._lost_now + 1, MAX_GAPS)
            log.error("%s", _gap(first, last))

    @property
    def gaps(self) -> tuple[str, ...]:
        """The gaps that this start found, as sentences."""
        with self.lock:
            return tuple(_gap(*gap) for gap in self.lost[len(self.lost) - self._lost_now :][-MAX_SENTENCES:])

    @property
    def unsaved(self) -> list[Row]:
        """The rows that the file lacks, in their order."""
        rows = [self._waiting[revision] for revision in sorted(self._waiting)]
        begun_anew = self.file is None or self.newest is None or self.file.newest != self.newest.revision
        return [self.newest] if not rows and begun_anew and self.newest is not None else rows

    def saved(self) -> None:
        """Notes that all rows are in the file."""
        self._waiting.clear()

    def at(self, t: float) -> Row:
        """The model that was served at the vehicle's time t [s]: the newest revision that is not younger.

        Raises:
            NotKept: the history does not say.
        """
        with self.lock:
            waiting = sorted(self._waiting.values())
            found = next((row for row in reversed(waiting) if row.t <= t), None)
            following = next((row for row in waiting if found is None or row.revision > found.revision), None)
            if found is None and self.file is not None:
                with self._reading("the index of times"):
                    found, saved = self.file.at(t)
                    following = saved or following
            if found is None:
                raise NotKept(f"no model is kept from the vehicle's time {t:g} s or before")
            if found.revision != (self.published if following is None else following.previous):
                lost = f"revisions after {found.revision} are lost"
                raise NotKept(f"what was served at {t:g} s is not kept: {lost}")
            return found

    def revision(self, revision: int) -> Row:
        """The published model and report of a revision.

        Raises:
            NotKept: it is not in the history, or damaged there.
        """
        with self.lock:
            found = self._waiting.get(revision)
            gap = next((gap for gap in self.lost if gap[0] <= revision <= gap[1]), None)
            if found is None and gap is not None:
                raise NotKept(f"revision {revision} is not kept; {_gap(*gap)}")
            if found is None and self.file is not None:
                with self._reading(f"revision {revision}"):
                    found = self.file.row(revision)
                    if found is None and max(self.file.newest - self._keep, 0) < revision <= self.file.newest:
                        raise StateDamage("its row is missing")
            if found is None:
                raise NotKept(f"revision {revision} is not kept; the latest is {self.published}")
            return found

    def reports(self, after: int, limit: int, most_bytes: int) -> list[bytes]:
        """Iteration reports after a revision, in their order: at most `limit`, and with the last about so many bytes.

        A damaged one is left out, and told in `damage`.
        """
        with self.lock:
            saved = []
            if self.file is not None:
                with self._reading("the list of revisions"):
                    saved = self.file.revisions(after, limit)
            waiting = sorted(revision for revision in self._waiting if revision > max([after, *saved]))
            found: list[bytes] = []
            for revision in [*saved, *waiting][:limit]:
                try:
                    found.append(self.revision(revision).report)
                except NotKept:
                    continue
                if sum(map(len, found)) >= most_bytes:
                    break
            return found

    @contextmanager
    def _reading(self, what: str) -> Iterator[None]:
        try:
            yield
        except StateDamage as error:
            sentence = f"{what} is damaged in the history"
            if sentence not in self.damage:
                log.error("%s: %s", sentence, error)
                self.damage = (*self.damage, sentence)[-MAX_SENTENCES:]
            raise NotKept(f"{sentence}: {error}") from error
        except sqlite3.Error as error:
            raise NotKept(f"the history cannot be read: {error}") from error


MAX_SENTENCES = 10
"""Sentences about damage that are told; a file that is damaged all over would fill health else."""
MAX_GAPS = 1_000
"""Gaps that are remembered, one for each time that a disk was full; the oldest go."""


def _gap(first: int, last: int) -> str:
    if first == last:
        return f"revision {first} was published and is lost: the disk does not have it"
    return f"revisions {first} to {last} were published and are lost: the disk does not have them"


def _size(row: Row) -> int:
    return len(row.snapshot) + len(row.report)
