"""The files that a browser may fetch: those of the archive, which `serve --archive` writes, and nothing beside them."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

_NAME = re.compile(r"[A-Za-z0-9_.-]+\.mcap")
"""A prefix has no other characters, so neither have the names of its files."""


@dataclass(frozen=True, slots=True)
class Recordings:
    """The archive in a folder; None where nothing is archived. Only its regular files count: no link, no pipe."""

    folder: Path | None

    def listed(self) -> list[dict[str, Any]]:
        """Name and size of each, the newest first."""
        found = []
        for path in () if self.folder is None else sorted(self.folder.glob("*.mcap"), reverse=True):
            try:
                status = path.lstat()
            except OSError:  # removed just now
                continue
            if stat.S_ISREG(status.st_mode) and _NAME.fullmatch(path.name):
                found.append({"name": path.name, "bytes": status.st_size})
        return found

    def opened(self, name: str) -> IO[bytes] | None:
        """The file of this name, open to read; None where it is none of them.

        It is opened without following a link and without waiting for a pipe, and looked at only then: what is in its
        place may change at any time.
        """
        if self.folder is None or not _NAME.fullmatch(name):
            return None
        try:
            number = os.open(self.folder / name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError:
            return None
        if not stat.S_ISREG(os.fstat(number).st_mode):
            os.close(number)
            return None
        return os.fdopen(number, "rb")
