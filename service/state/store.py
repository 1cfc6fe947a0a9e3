"""The durable state: the learner's memory after each iteration, and the history of its published revisions.

One file for each learner (`state_file`). A state that does not fit, is damaged or cannot be taken up is set
aside under another name, never half-read, and one that was set aside earlier comes back where it fits. While the disk
takes nothing, the newest revisions wait in the process's memory, and are answered from there.
"""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.config.configuration import Config
from service.state.disk_refusals import OTHER_STATE, is_read_only, may_pass, refusal, unwritable
from service.state.history import History
from service.state.matching import LOST_KEY, bring_back, has_lost_file, identity, open_state, set_aside
from service.state.state_file import StateDamage, StateFile, StateLock
from service.wire.json_text import json_text

log = logging.getLogger(__name__)


class Store:
    """The durable state of one learner; every method may be called from any thread.

    Args:
        directory: where its file is.
        config: whose it is.
        effects: names the traced effects that samples are freed of.
        changing: the effects may change while it learns: then the memory says under `effects` which they are.
        anew: sets a state that is there aside, and begins another.

    Attributes:
        memory: the learner's memory as it was last saved; None where it begins anew.
        history: answers for what was published.
        problem: why what was learned last is not on the disk; None where it is.

    Raises:
        BadInput: the directory cannot be written, or another learner has this state. A full disk is no reason.
    """

    def __init__(
        self, directory: Path, config: Config, effects: str | None = None, changing: bool = False, anew: bool = False
    ) -> None:
        self.path = directory / (config.prefix + ".sqlite")
        self.memory: dict[str, Any] | None = None
        self.problem: str | None = None
        self._identity, self._changing, self._keep = identity(config, effects), changing, config.history
        self.history = History(config.history)
        self._sentences: tuple[str, ...] = ()
        self._lock: StateLock | None = None
        self._memory_bytes = b"null"  # the memory, as the file has it
        self._refused: frozenset[Path] = frozenset()
        self._read_only = False
        try:
            self._begin(anew)
            self._look()
        except (OSError, sqlite3.Error) as error:
            if not may_pass(error):
                self.close()
                why_not = refusal(error, self.path, OTHER_STATE)
                raise BadInput(f"the state cannot be kept in {directory}: {why_not}") from error
            self._fails(error)
        except BaseException:
            self.close()
            raise
        self._count()

    def _look(self) -> None:
        """Says before the first revision where the state that was read cannot be written."""
        for place in (self.path, self.path.parent):
            why_not = unwritable(place, OTHER_STATE)
            if why_not is not None:
                self._read_only, self.problem = True, why_not
                log.error("the state %s cannot be written: %s", self.path, why_not)
                return

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences on states that were set aside, lost or damaged."""
        return (*self._sentences, *self.history.damage, *self.history.gaps)

    @property
    def published(self) -> int:
        """The highest revision that is known to be given, saved or not."""
        return self.history.published

    @property
    def _file(self) -> StateFile | None:
        return self.history.file

    def refuse(self, reason: str) -> None:
        """The memory cannot be taken up: its state is set aside, and another one takes its place."""
        with self.history.lock:
            try:
                self._another(reason)
            except (OSError, sqlite3.Error) as error:
                self._fails(error)
            self._count()

    def save(self, memory: Mapping[str, Any], revision: int, t: float, snapshot: bytes, report: bytes) -> None:
        """Saves one iteration as a whole; when this returns it is on the disk, or `problem` says why not."""
        with self.history.lock:
            self.history.add(revision, t, snapshot, report)
            self._remember(memory)
            self._write()

    def save_memory(self, memory: Mapping[str, Any]) -> None:
        """Saves the memory alone: what is on its way to the next batch at the end, or a step of tracing."""
        with self.history.lock:
            self._remember(memory)
            self._write()

    @property
    def due(self) -> bool:
        """Whether `save_again` has something to do: the disk took nothing the last time, or the file is gone."""
        file = self._file
        return self.problem is not None or file is None or not file.in_place

    def save_again(self) -> None:
        """Saves what could not be saved, or what was removed since."""
        with self.history.lock:
            if self.due:
                self._write()

    def close(self) -> None:
        with self.history.lock:
            if self._file is not None:
                self._file.close()
            if self._lock is not None:
                self._lock.close()

    def _begin(self, anew: bool) -> None:
        """Takes up the state that is there, or another one that fits, or begins anew."""
        claim = self._take_claim()
        if anew:
            if self.path.exists():
                set_aside(self.path)
            self._create()
        elif self.path.exists():
            try:
                self._adopt()
            except StateDamage as error:
                self._another(str(error))
        elif claim.marked or has_lost_file(self.path):
            self._another("it is missing, although a learner saved it here")
        else:
            self._create()

    def _take_claim(self) -> StateLock:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        taken = StateLock(self.path.with_suffix(".lock"), self.path)
        if self._lock is not None:
            self._lock.close()
        self._lock = taken
        return taken

    def _adopt(self) -> None:
        """Takes up the state in its place."""
        taken = open_state(self.path, self._identity, self._changing)
        self.history.remember(taken.lost)
        self.history.file, self.memory, self._memory_bytes = taken.file, taken.memory, json_text(taken.memory).encode()

    def _count(self) -> None:
        """Counts on from the revisions that were given already."""
        saved = 0 if self._file is None else self._file.newest
        learned = 0 if self.memory is None else self.memory.get("revision")
        if not isinstance(learned, int):
            learned = 0  # the memory will be refused
        if learned > saved:
            self._tell(f"the history in {self.path} lacks the newest revision, {learned}")
        given = 0 if self._lock is None else self._lock.published
        self.history.published = max(saved, learned, given)
        if given > max(saved, learned):
            self.history.lose(max(saved, learned) + 1, given)

    def _another(self, reason: str) -> None:
        """The replacement of a lost or unsuitable state: one set aside earlier that fits, or a new one."""
        self.memory, self._memory_bytes = None, b"null"
        if self.path.exists():
            aside = self._put_aside()
            self._refused |= {aside}
            said = f"the state {self.path} was set aside as {aside.name}: {reason}"
        else:
            said = f"the state {self.path} is lost: {reason}"
        earlier = bring_back(self.path, self._identity, self._changing, self._refused)
        if earlier is None:
            self._tell(f"{said}; learning starts with an empty model")
            self._create()
        else:
            self._tell(f"{said}; {earlier.name} fits and was restored")
            self._adopt()

    def _create(self, known: StateFile | None = None) -> None:
        """A new file; with all that a known one holds where that is given."""
        self.history.file = StateFile.create(self.path, self._identity, known)
        if self._lock is not None and not self._lock.marked:
            self._lock.mark(0)

    def _put_aside(self) -> Path:
        if self._file is not None:
            self._file.close()
            self.history.file = None
        return set_aside(self.path)

    def _remember(self, memory: Mapping[str, Any]) -> None:
        self._memory_bytes = json_text(memory).encode()
        if self._changing:
            self._identity = {**self._identity, "effects": memory.get("effects")}

    def _write(self) -> None:
        """All that waits is on the disk after it, in a file of this name; else `problem` says why not."""
        try:
            self._stand()
            try:
                self._write_rows()
            except StateDamage as error:
                self._tell(f"the state was set aside as {self._put_aside().name} while the learner ran: {error}")
                self._create()
                self._write_rows()
        except (OSError, sqlite3.Error, StateDamage, BadInput) as error:
            self._fails(error)
            return
        if self.problem is not None:
            log.warning("the state %s is written again", self.path)
        self.problem = None
        self.history.saved()

    def _write_rows(self) -> None:
        assert self._file is not None
        changed: dict[str, Any] = {"effects": self._identity["effects"]} if self._changing else {}
        if self.history.gaps:
            changed[LOST_KEY] = self.history.lost
        self._file.write(self._memory_bytes, self.history.unsaved, self._keep, changed)

    def _stand(self) -> None:
        """The file is where it belongs, and the lock is ours."""
        if self._lock is None or not self._lock.in_place:
            self._take_claim()
        gone = self._file
        if gone is not None and gone.in_place:
            if self._read_only:  # a connection that was opened while the disk was read-only stays so
                self.history.file = StateFile(self.path)
                gone.close()
                self._read_only = False
            return
        if self.path.exists():
            log.error("the state in %s was set aside as %s", self.path, set_aside(self.path).name)
        try:
            self._create(gone)
        except StateDamage:  # what is gone was emptied before
            self._create()
        if gone is not None:
            gone.close()
            self._tell(f"the state {self.path} was removed while the learner ran, and was written again")

    def _fails(self, error: Exception) -> None:
        """The disk takes nothing now: says so, and marks the revisions that were given, so that none is given twice."""
        problem = refusal(error, self.path, OTHER_STATE)
        if self.problem is None:
            log.error("the state %s cannot be written: %s", self.path, problem)
        self.problem, self._read_only = problem, is_read_only(error)
        claim = self._lock
        if claim is None or not self.history.unsaved or claim.published >= self.published:
            return
        try:
            claim.mark(self.published)
        except OSError as fault:
            log.error("revision %d of %s may be given again after a restart: %s", self.published, self.path, fault)

    def _tell(self, sentence: str) -> None:
        log.error("%s", sentence)
        self._sentences = (*self._sentences, sentence)
