"""What was assumed of a log begins its refusal, with the flag that says better, and stands beside a result."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from service.cli.command_line import main
from tests.service import link
from tests.service.logs.dive import dive

DIVE = dive(seconds=30.0)
CANCELS = (1, -1, 1, -1)
"""Directions of which the moments cancel where all are taken for +1."""
OWN = "{FRAME_CONFIG: 1, MOT_1_DIRECTION: 1, MOT_2_DIRECTION: -1, MOT_3_DIRECTION: 1, MOT_4_DIRECTION: -1}"


def log(folder: Path, directions: tuple[int, ...]) -> str:
    said = link.swum(DIVE, link.pulses(DIVE, directions), armed_from=0.0)
    return str(link.as_tlog(folder / "dive.tlog", said))


@pytest.mark.parametrize(("directions", "turned"), [(CANCELS, True), ((-1, -1, -1, -1), False)])
def test_a_refusal_begins_with_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], directions: tuple[int, ...], turned: bool
) -> None:
    path = log(tmp_path, directions)
    assert main(["fit", path, "--inertia", "0.6"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("incsvr fit: the vehicle has not sent FRAME_CONFIG and others: assumed a BlueROV2 (frame 1,")
    cure = re.search(r"as in (--set '[^']*')", said)
    assert cure is not None
    main(["fit", path, "--inertia", "0.6", *shlex.split(cure[1])])  # the flag as it is written is understood
    assert "MOT_2_DIRECTION" in "".join(capsys.readouterr())
    if turned:
        assert main(["fit", path, "--inertia", "0.6", "--set", f"inputs.parameters={OWN}"]) == 0
        assert "assumed" not in capsys.readouterr().out


def test_it_stands_beside_a_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", log(tmp_path, (1, 1, 1, 1)), "--inertia", "0.6"]) == 0
    assert "assumed a BlueROV2 (frame 1, T200 thrusters), all directions +1" in capsys.readouterr().out
