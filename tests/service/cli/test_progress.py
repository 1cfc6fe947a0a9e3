"""Who sees a progress bar while a log is read: people at a terminal, and nobody else."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator import leng

#: Without patience a bar is there at once, so that no log must be large enough for it.
IMPATIENT = (
    "import sys, service.cli.progress as p; p.BAR_AFTER_S = 0.0; "
    "from service.cli.command_line import main; sys.exit(main())"
)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    whole, path = leng.recording("T1", 1), tmp_path_factory.mktemp("progress") / "dive.csv"
    write(path, Recording("dive", whole.time, {"r": whole.columns["yaw_rate"], "tau": whole.columns["torque"]}))
    return path


def seen(*words: str) -> str:
    """What a command writes to its standard error, a terminal."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", IMPATIENT, *words]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs, env=os.environ | {"TERM": "xterm"}) as it:
        os.close(theirs)
        found = b""
        try:
            while part := os.read(ours, 65_536):
                found += part
        except OSError:  # the other end is closed
            pass
        assert it.wait() == 0, found
    os.close(ours)
    return found.decode()


@pytest.mark.slow
def test_people_see_that_a_log_is_read_and_programs_see_nothing(log: Path) -> None:
    assert seen("inspect", str(log), "--json", os.devnull) == ""
    learned = seen("fit", str(log), "--inertia", "350")
    assert "reading dive.csv" in learned
    assert "learning" in learned


@pytest.mark.slow
def test_where_standard_error_is_no_terminal_nothing_is_seen(log: Path) -> None:
    command = [sys.executable, "-c", IMPATIENT, "inspect", str(log)]
    assert subprocess.run(command, capture_output=True, check=True).stderr == b""
