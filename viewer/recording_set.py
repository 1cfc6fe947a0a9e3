"""The recordings of one start: written, set aside, joined, closed."""

from __future__ import annotations

import logging
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW, Axis
from viewer import archive
from viewer.compare import Choice
from viewer.pages import blueprint
from viewer.palette import Palette
from viewer.recorder import Recorder, new_recording
from viewer.recording_pages import RecordingPages

log = logging.getLogger(__name__)


class RecordingSet:
    """The recordings of one start: those that are open, and the file that keeps them all.

    A file that is there already is kept aside and joined with the new one in the end: a restart goes on, nothing is
    overwritten, and after kill -9 the file holds all since the start, and `….before.rrd` what was before.
    """

    def __init__(
        self, palette: Palette, choice: Choice, rate: float, path: Path | None, port: int | None, axis: Axis = YAW
    ) -> None:
        self._palette, self._choice, self._rate, self._path, self._port = palette, choice, rate, path, port
        self._axis = axis
        self._before = None if path is None else path.with_suffix(".before.rrd")
        self.recorded = 0
        self._pages: RecordingPages | None = None
        recording = new_recording()
        if path is not None:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise BadInput(f"{path.parent}: cannot be made ({error.strerror}); record elsewhere") from None
            found = self._set_aside()
            if found is not None:
                recording, self.recorded = found
                log.info("%s continues after revision %d", path, self.recorded)
        self._open(recording)

    @property
    def pages(self) -> RecordingPages:
        assert self._pages is not None
        return self._pages

    @property
    def broken(self) -> bool:
        """Whether a file could not be written to its end."""
        return self.pages.recorder.broken

    def begin(self) -> RecordingPages:
        """Closes the pages that are open and begins the next."""
        log.info("a new recording begins")
        self.pages.recorder.close()
        if self._path is not None and not self.pages.recorder.broken:
            self._set_aside()
        return self._open(new_recording())

    def close(self) -> bool:
        """Closes the file, joins, halves and reads it again; whether it holds everything."""
        recorder = self.pages.recorder
        self.pages.flush()
        recorder.close()
        if self._path is None or self._before is None:
            return True
        parts = [part for part in (self._before, self._path) if part.exists()]
        log.info("closing %s: a recording of hours takes minutes", self._path)
        try:
            archive.optimise(parts, self._path)
        except BadInput as error:
            log.error("%s", error)
            return False
        found = archive.last_revision(self._path)
        if self.pages.revision and (found is None or found[1] != self.pages.revision):
            log.error("%s does not hold all up to revision %d", self._path, self.pages.revision)
            return False
        self._before.unlink(missing_ok=True)
        log.info("%s: %.2f MB; open it with `incsvr view %s`", self._path, self._path.stat().st_size / 1e6, self._path)
        return not recorder.broken

    def _open(self, recording: str) -> RecordingPages:
        layout = blueprint(self._palette, self._choice, axis=self._axis)
        try:
            recorder = Recorder(recording, layout, path=self._path, port=self._port, axis=self._axis)
        except (RuntimeError, OSError) as error:
            raise BadInput(f"{self._path}: cannot be written ({error}); free some space or record elsewhere") from None
        self._pages = RecordingPages(recorder, self._palette, self._choice, self._rate)
        return self._pages

    def _set_aside(self) -> tuple[str, int] | None:
        """Moves what is in the file to where it is kept; the newest recording in it and its last revision."""
        assert self._path is not None
        assert self._before is not None
        parts = [part for part in (self._before, self._path) if part.exists() and part.stat().st_size > 0]
        if not parts:
            return None
        for part in parts:
            if not archive.facts(part).complete:
                log.warning("%s was cut off; it is mended", part)
        archive.optimise(parts, self._before)
        self._path.unlink(missing_ok=True)
        return archive.last_revision(self._before)
