"""Every command of docs/logs.md runs as it stands there, on logs that are made for it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from service.cli.command_line import main
from tests.conftest import ROOT
from tests.service import link
from tests.service.logs.dive import dive
from tests.service.logs.test_vehicles import ulog

PAGE = (ROOT / "docs" / "logs.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^incsvr (.*)$", PAGE, re.MULTILINE)
CONFIGURATION = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that the page speaks of."""
    at, truth = tmp_path_factory.mktemp("logs"), dive(seconds=40.0)
    said = link.in_order(link.parameters(), link.swum(truth))
    link.as_dataflash(at / "dive.BIN", said)
    link.as_tlog(at / "dive.tlog", said)
    (at / "dive.ulg").write_bytes(ulog(truth))
    rows = zip((1000.0 * truth.time).tolist(), (-57.29578 * truth.rate).tolist(), truth.torque.tolist(), strict=True)
    (at / "others.csv").write_text("stamp;r;tau\n" + "".join(f"{t:.0f};{r};{tau}\n" for t, r, tau in rows))
    learner = "vehicle: {rate_range: [-2.0, 2.0], rate_limit: 6.0}\nsignals: {sample_period: 0.1, smoothing: 0.1}\n"
    (at / "dive_config.yaml").write_text(CONFIGURATION + learner, encoding="utf-8")
    return at


@pytest.mark.parametrize(
    "command", [pytest.param(each, marks=pytest.mark.slow) if each.startswith("trace") else each for each in COMMANDS]
)
def test_a_command_of_the_page_runs(
    folder: Path, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    words = shlex.split(command, comments=True)
    assert main(words) == 0, capsys.readouterr().err
    assert all(len(line) <= 80 for line in capsys.readouterr().out.splitlines() if words[0] == "inspect")
