"""The demo's processes: each command one of its own, whose words go to a log, and none left behind."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from incsvr.errors import Failed

START_TIMEOUT_S = 30.0
"""A process of the demo starts within this time [s]."""
STOP_TIMEOUT_S = 10.0
"""A process of the demo that is asked to end does so within this time [s]; else it is killed."""


def command(*words: str) -> list[str]:
    """The words that start a command of this program."""
    return [sys.executable, "-m", "service.cli.command_line", *words]


@contextmanager
def process_of(out: Path, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A command as a process that ends with the block; what it says goes to a log."""
    with (out / f"{words[0]}.log").open("wb") as log:
        # In a session of its own Ctrl-C reaches us alone, and we end the others in their order.
        process = subprocess.Popen(command(*words), stdout=log, stderr=log, start_new_session=True)
        try:
            yield process
        finally:
            end(process)


def wait_until_ready(viewer: subprocess.Popen[bytes], log: Path) -> None:
    """Returns once the viewer hears the bus, so that the recording begins with the first measurement."""
    until = time.monotonic() + START_TIMEOUT_S
    while "viewer ready" not in log.read_text(encoding="utf-8", errors="replace"):
        if viewer.poll() is not None or time.monotonic() > until:
            raise Failed(f"the viewer did not start; see {log}")
        time.sleep(0.05)


def end(process: subprocess.Popen[bytes]) -> None:
    """Ends a process, and waits for its end."""
    process.terminate()
    try:
        process.wait(STOP_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def verify(recording: Path, people: Any) -> bool:
    """Whether Rerun's own check finds the recording whole."""
    tool = Path(sys.executable).with_name("rerun")
    done = subprocess.run([tool, "rrd", "verify", recording], capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stdout + done.stderr, file=people)
    return done.returncode == 0
