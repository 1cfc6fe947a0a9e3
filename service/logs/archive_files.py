"""The files of an archive (`serve --archive`): how they are named, and what they begin with."""

from __future__ import annotations

import re
from pathlib import Path

ARCHIVE_PROFILE = "incsvr"
"""The profile of the files: by it `replay` knows that they hold what came, as it came."""
METADATA_NAME = "incsvr"
"""The name of the metadata that every file begins with."""
JSON_ENCODING = "json"
"""The encoding of what is JSON, as MCAP calls it."""


def archive_files(directory: Path, name: str = "") -> list[Path]:
    """The files of an archive, the oldest first; `name` is the learner's `Keys.file_name`, empty for all."""
    pattern = re.compile(rf"{re.escape(name) if name else '.+'}_\d{{6,}}\.mcap")
    return sorted((path for path in directory.glob("*.mcap") if pattern.fullmatch(path.name)), key=number)


def number(path: Path) -> int:
    """The place of a file among those of its archive."""
    return int(path.stem.rpartition("_")[2])
