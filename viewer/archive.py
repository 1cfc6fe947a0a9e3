"""Recordings on disk: whole or cut off, of which release, mended, joined, verified."""

from __future__ import annotations

import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

import rerun as rr
import rerun_cli  # type: ignore[import-untyped]
from rerun.chunk import RrdReader

from incsvr.errors import BadInput
from viewer.newest_pages import superseded, without

MAGIC, FOOTER = b"RRF2", b"RRF2FOOT"
#: The binary itself: the installed command is a shim whose child outlives it.
BINARY = Path(rerun_cli.__file__).parent / "rerun"


@dataclass(frozen=True, slots=True)
class Facts:
    """What a recording's first and last bytes say.

    Attributes:
        release: of Rerun, that wrote it, such as "0.41.0".
        complete: whether it was closed; one that was cut off is readable up to its last iteration.
    """

    release: str
    complete: bool


def facts(path: Path) -> Facts:
    """Reads what a recording says about itself.

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
            f"{path}: this is no recording of the viewer (.rrd); a log is drawn by `incsvr inspect {path} --plot FILE`"
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
    return Facts(release, FOOTER in tail)


def last_revision(path: Path) -> tuple[str, int] | None:
    """The newest recording in the file and the last revision of the model in it; None where it holds none."""
    reader = RrdReader(str(path))
    entries = sorted(reader.recordings(), key=lambda entry: entry.recording_id)
    if not entries:
        return None
    revisions = [
        int(value)
        for chunk in reader.stream(store=entries[-1]).filter(content="/learning/revision")
        for row in chunk.to_record_batch().column("Scalars:scalars").to_pylist()
        for value in row or ()
    ]
    return (entries[-1].recording_id, max(revisions)) if revisions else None


def optimise(parts: list[Path], out: Path) -> None:
    """Joins the recordings into one file, the newest last, mended and half the size, with the newest pages alone.

    Raises:
        BadInput: a part cannot be read, or the disk is full; the parts are left as they are.
    """
    unfinished = out.with_name(out.name + ".tmp")
    copies: list[Path] = []
    try:
        older = superseded(parts)
        if older:
            copies = [out.with_name(f"{out.name}.{number}.tmp") for number in range(len(parts))]
            for part, copy in zip(parts, copies, strict=True):
                without(part, older, copy)
        done = _rerun("rrd", "optimize", "--continue-on-error", *map(str, copies or parts), "-o", str(unfinished))
    except OSError as error:
        raise BadInput(f"{out}: cannot be optimised ({error.strerror}); it is kept as it was written") from None
    finally:
        for copy in copies:
            copy.unlink(missing_ok=True)
    if done.returncode != 0:
        unfinished.unlink(missing_ok=True)
        raise BadInput(
            f"{out}: cannot be optimised ({_last_line(done.stderr)}); the recording is kept as it was written"
        )
    unfinished.replace(out)


def verify(path: Path) -> None:
    """Has Rerun read the whole file.

    Raises:
        BadInput: it is damaged.
    """
    done = _rerun("rrd", "verify", str(path))
    if done.returncode != 0:
        raise BadInput(f"{path}: the recording is damaged ({_last_line(done.stderr)}); mend it with --repair")


def _rerun(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([BINARY, *words], capture_output=True, text=True, check=False)


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["no reason given"])[-1].strip()
