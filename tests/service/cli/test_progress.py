"""Who sees progress: people at a terminal a bar, who read a file lines, and programs nothing."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from simulator import leng
from simulator.dive_log import write_dive

#: Without patience a bar is there at once, so that no log must be large enough for it.
IMPATIENT = (
    "import sys, service.cli.progress as p; p.BAR_AFTER_S, p.LINE_PERIOD_S = 0.0, 0.1; "
    "from service.cli.command_line import main; sys.exit(main())"
)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    whole, path = leng.recording("T1", 1), tmp_path_factory.mktemp("progress") / "dive.csv"
    write(path, from_table("dive", whole.time, {"r": whole.columns["yaw_rate"], "tau": whole.columns["torque"]}))
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
def test_identify_names_its_step_on_a_terminal_and_in_a_file(tmp_path: Path) -> None:
    dive = tmp_path / "dive.csv"
    write_dive(dive, "torpedo", 1)
    assert "identifying: fitting all axes together" in seen("identify", str(dive))
    command = [sys.executable, "-c", IMPATIENT, "identify", str(dive)]
    lines = subprocess.run(command, capture_output=True, check=True, text=True).stderr.splitlines()
    assert any(re.fullmatch(r"incsvr: identifying, 1 of \d+: fitting all axes together, \d+ s", line) for line in lines)
    silent = subprocess.run([*command, "--json", "-"], capture_output=True, check=True, text=True).stderr
    assert "identifying" not in silent
