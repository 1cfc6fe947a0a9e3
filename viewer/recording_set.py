"""The recordings of one start: a file each."""

from __future__ import annotations

import logging
from collections.abc import Callable
from itertools import count
from pathlib import Path

from incsvr.errors import BadInput
from viewer.recorder import Recorder
from viewer.recording_pages import RecordingPages

log = logging.getLogger(__name__)

Open = Callable[[Path | None], RecordingPages]
"""Opens the pages of a new recording that goes to this file, too."""


class RecordingSet:
    """The recording that is open, and those before it: a learner or a clock that begins anew gets the next file.

    Nothing is overwritten: where `run.rrd` exists, the recording goes to `run-2.rrd`.
    """

    def __init__(self, path: Path | None, open_pages: Open) -> None:
        self._path, self._open = path, open_pages
        self.pages = self._next()

    def begin(self) -> RecordingPages:
        """Closes the recording that is open and begins the next."""
        log.info("a new recording begins")
        self.close()
        self.pages = self._next()
        return self.pages

    def close(self) -> bool:
        """Closes the file; whether it holds everything."""
        recorder: Recorder = self.pages.recorder
        self.pages.flush()
        recorder.close()
        if recorder.path is not None and not recorder.broken:
            size = recorder.path.stat().st_size / 1e6
            log.info("%s: %.2f MB; open it with `incsvr view %s`", recorder.path, size, recorder.path)
        return not recorder.broken

    def _next(self) -> RecordingPages:
        path = self._path
        try:
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
                further = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
                path = path if not _has_data(path) else next(each for each in further if not _has_data(each))
            return self._open(path)
        except (RuntimeError, OSError) as error:
            raise BadInput(f"{path}: cannot be written ({error}); free some space or record elsewhere") from None


def _has_data(path: Path) -> bool:
    return path.exists() and path.stat().st_size > 0
