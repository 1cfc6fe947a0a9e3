"""Rerun's own window, and whether it can open a recording."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun_cli  # type: ignore[import-untyped]

from incsvr.errors import BadInput

MAGIC, FOOTER = b"RRF2", b"RRF2FOOT"
#: The binary itself: the installed command is a shim whose child outlives it.
BINARY = Path(rerun_cli.__file__).parent / "rerun"


def is_whole(path: Path) -> bool:
    """Whether a recording was closed; one that was cut off is readable up to its last iteration.

    Raises:
        BadInput: there is no such file, it is no recording, or another release wrote it.
    """
    try:
        with path.open("rb") as file:
            head = file.read(12)
            file.seek(max(0, path.stat().st_size - 64))
            tail = file.read()
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such recording; `incsvr view --save {path}` makes one") from None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror})") from None
    if len(head) < 12 or not head.startswith(b"RRF"):
        raise BadInput(
            f"{path}: this is no recording of the viewer (.rrd); `incsvr inspect {path} --plot FILE` draws a log"
        )
    major, minor, patch, _ = struct.unpack("4B", head[4:8]) if head.startswith(MAGIC) else (0, 0, 0, 0)
    release = f"{major}.{minor}.{patch}"
    ours = tuple(int(part) for part in rr.__version__.split(".")[:2])
    if (major, minor) > ours or major != ours[0] or minor < ours[1] - 1:
        raise BadInput(
            f"{path}: Rerun {release} wrote this and {rr.__version__} is installed, which reads its own recordings and "
            f"those of the release before: open it with `pip install rerun-sdk=={release}` and `rerun {path}`, or "
            "record the run again from its CSV with `incsvr replay`"
        )
    return FOOTER in tail


@contextmanager
def window(*shows: str | Path) -> Iterator[subprocess.Popen[bytes]]:
    """The window on a recording, or on `--connect URL`; leaving closes it.

    Raises:
        BadInput: there is no screen.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise BadInput("there is no screen here: give --headless --save FILE.rrd and look at the file elsewhere")
    words = ("--bind", "127.0.0.1", "--port", "auto", "--hide-welcome-screen")
    with subprocess.Popen([BINARY, *words, *shows]) as process:
        try:
            yield process
        finally:
            process.terminate()
