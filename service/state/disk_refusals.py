"""The reasons why nothing can be written, with the cure: a read-only, full or failing disk, or missing rights."""

from __future__ import annotations

import errno
import os
import pwd
import sqlite3
from pathlib import Path

_PASSING_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO})
_FULL_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT})
_DENIED_ERRORS = frozenset({errno.EACCES, errno.EPERM})
_NO_DIRECTORY_ERRORS = frozenset({errno.ENOTDIR, errno.EEXIST})
OTHER_STATE = "set `state` to another directory"
OTHER_ARCHIVE = "name another one with --archive"


def may_pass(error: Exception) -> bool:
    """Whether a disk may take again later, by itself or after a repair, what it does not take now."""
    if isinstance(error, OSError):
        return error.errno in _PASSING_ERRORS
    code = _code(error)
    return code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_READONLY)


def is_read_only(error: Exception) -> bool:
    """Whether a writer met what may only be read."""
    return getattr(error, "errno", None) == errno.EROFS or _code(error) == sqlite3.SQLITE_READONLY


def refusal(error: Exception, path: Path, otherwise: str) -> str:
    """The reason why nothing can be written at `path`, and the cure; `otherwise` names the alternative."""
    number, code, place = getattr(error, "errno", None), _code(error), _nearest_place(path)
    if number == errno.EROFS or (code is not None and _mounted_read_only(place)):
        return _read_only_sentence(place, otherwise)
    if number in _FULL_ERRORS or code == sqlite3.SQLITE_FULL or (code == sqlite3.SQLITE_IOERR and _is_full(place)):
        return f"no space is left on the disk of {place}; free some, or {otherwise}"
    if number in _DENIED_ERRORS or code == sqlite3.SQLITE_READONLY:
        return _denied_sentence(Path(getattr(error, "filename", None) or place), otherwise)
    if number == errno.EIO or code == sqlite3.SQLITE_IOERR:
        return f"the disk of {place} fails ({error}); look into the log of the kernel (dmesg), or {otherwise}"
    if number in _NO_DIRECTORY_ERRORS:
        return f"{place} is no directory; {otherwise}"
    return f"{error}; {otherwise}"


def unwritable(path: Path, otherwise: str) -> str | None:
    """The reason why a file or directory, or its future place, cannot be written; None if it can."""
    place, effective = _nearest_place(path), os.access in os.supports_effective_ids
    if place != path.absolute() and not place.is_dir():
        return f"{place} is no directory; {otherwise}"
    if os.access(place, os.W_OK | (os.X_OK if place.is_dir() else 0), effective_ids=effective):
        return None
    return _read_only_sentence(place, otherwise) if _mounted_read_only(place) else _denied_sentence(place, otherwise)


def user_name(user: int | None = None) -> str:
    """The name of a user; of the one whose rights are in force without a number."""
    number = os.geteuid() if user is None else user
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return f"user {number}"


def _read_only_sentence(place: Path, otherwise: str) -> str:
    mount = next(folder for folder in (place, *place.parents) if folder.is_mount())
    return (
        f"the file system at {mount} is read-only; make it writable (`mount -o remount,rw {mount}`; a disk that fails "
        f"makes itself read-only: dmesg shows it), or {otherwise}"
    )


def _denied_sentence(place: Path, otherwise: str) -> str:
    me = user_name()
    return f"{place} cannot be written by {me}; give it to {me} (`chown {me} {place}`), or {otherwise}"


def _nearest_place(path: Path) -> Path:
    """The path as an absolute one, or the nearest folder above it that is there."""
    whole = path.absolute()
    return next(place for place in (whole, *whole.parents) if place.exists())


def _mounted_read_only(place: Path) -> bool:
    return bool(os.statvfs(place).f_flag & os.ST_RDONLY)


def _is_full(place: Path) -> bool:
    return os.statvfs(place).f_bavail == 0


def _code(error: Exception) -> int | None:
    """The primary code of an error of SQLite."""
    code = getattr(error, "sqlite_errorcode", None)
    return None if code is None else int(code) & 0xFF
