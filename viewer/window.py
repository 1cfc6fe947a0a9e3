"""Rerun's own window, with its texts and time plots in the theme that the axes have."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import rerun as rr
import rerun_cli  # type: ignore[import-untyped]

from incsvr.errors import BadInput
from viewer.palette import Theme

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


COMMAND: list[str | Path] = [BINARY, "--bind", "127.0.0.1", "--port", "auto", "--hide-welcome-screen"]


@contextmanager
def window(port: int, theme: Theme, closed: Callable[[], object]) -> Iterator[None]:
    """The window on a stream at this port; closing it calls `closed`, and leaving closes it.

    Raises:
        BadInput: there is no screen.
    """
    need_a_screen()
    url = f"rerun+http://127.0.0.1:{port}/proxy"
    with (
        themed(theme) as (flags, environment),
        subprocess.Popen([*COMMAND, *flags, "--connect", url], env=environment) as process,
    ):
        threading.Thread(target=when, args=(process.wait, closed), daemon=True).start()
        try:
            yield
        finally:
            process.terminate()


def look(recording: Path, theme: Theme | None) -> int:
    """The window on a recording until it is closed, in the theme of Rerun's own settings unless one is named."""
    need_a_screen()
    with themed(theme) as (flags, environment):
        return subprocess.run([*COMMAND, *flags, recording], env=environment, check=False).returncode


@contextmanager
def themed(theme: Theme | None) -> Iterator[tuple[list[str], dict[str, str]]]:
    """Flags and environment with which Rerun's viewer begins in a theme, apart from the settings of its user.

    The theme is no flag and no part of a blueprint: it stands in the settings that a viewer of the same release left,
    which Linux keeps where XDG_DATA_HOME says. Elsewhere the viewer has its own settings, and its texts its own theme.
    """
    environment = dict(os.environ)
    if theme is None or not sys.platform.startswith("linux"):
        yield [], environment
        return
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        settings = Path(folder) / "rerun" / "app.ron"
        settings.parent.mkdir()
        preference = f"(options:(theme_preference:{theme.capitalize()}))"
        settings.write_text(f'{{"rerun.version": "{rr.__version__}", "egui": "{preference}"}}', encoding="utf-8")
        yield ["--persist-state"], environment | {"XDG_DATA_HOME": folder}


def need_a_screen() -> None:
    """Refuses where no window can open.

    Raises:
        BadInput: there is no screen.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise BadInput("there is no screen here: give --headless --save FILE.rrd and look at the file elsewhere")


def when(comes: Callable[[], object], then: Callable[[], object]) -> None:
    """Waits until `comes` returns, and calls `then`; for a thread of its own."""
    comes()
    then()
