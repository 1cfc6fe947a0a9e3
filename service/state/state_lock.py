"""The lock of a durable state: one learner has it, and the number of what it published is kept even on a full disk."""

from __future__ import annotations

import errno
import fcntl
import os
import zlib
from contextlib import ExitStack
from pathlib import Path

from incsvr.errors import BadInput

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
