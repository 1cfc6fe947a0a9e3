"""`incsvr fit --write`: a learner goes on from it, and one that begins anew with it does as well as `fit`."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.fitting import scaled as config_output
from service.recordings.recording_csv import write
from service.wire.json_text import json_text
from simulator import leng
from tests.service.conftest import PATIENCE, cut


def told(capsys: pytest.CaptureFixture[str], *words: str | Path) -> Any:
    assert main([*map(str, words), "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.slow
def test_what_fit_wrote_and_what_is_deployed_are_as_good_as_fit(
    capsys: pytest.CaptureFixture[str], measured: Path, tmp_path: Path
) -> None:
    runs, unseen = [measured / f"bluerov/run_0{n}.csv" for n in (3, 4)], measured / "bluerov/run_05.csv"
    written = tmp_path / "rov.yaml"
    words: list[str | Path] = [*runs, "--validate", unseen, "--inertia", "1.125"]
    fitted = told(capsys, "fit", *words, "--write", written, "--state", tmp_path)
    again = told(capsys, "fit", *words, "--config", written)
    deployed = told(capsys, "fit", *words, "--config", Path(__file__).parents[3] / "deploy" / "bluerov.yaml")
    assert max(each["validation"]["mae"] for each in (fitted, again, deployed)) < 0.63
    assert again["put_aside"] == deployed["put_aside"] == 0


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two minutes of Leng, in the folder in which the commands run."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "T1.csv", cut(leng.recording("T1", 3), 120.0))
    return tmp_path / "T1.csv"


@pytest.mark.slow
def test_serve_goes_on_from_what_fit_left(capsys: pytest.CaptureFixture[str], run: Path, tmp_path: Path) -> None:
    """Three commands: the first answer comes before any message, and learning and revisions go on with them."""
    written, endpoint, rates = tmp_path / "auv.yaml", free_endpoint(), ("0.1", "-0.2")
    fitted = told(capsys, "fit", run, "--inertia", "350", "--write", written, "--name", "auv")
    client = ("--config", written, "--connect", endpoint)
    serve = ["serve", "--config", str(written), "--listen", endpoint]
    process = subprocess.Popen([sys.executable, "-m", "service.cli.command_line", *serve], stderr=subprocess.PIPE)
    try:
        first = told(capsys, "query", *rates, *client)
        curve = np.interp([0.1, -0.2], fitted["curve"]["rate"], fitted["curve"]["damping"])
        assert first["damping"] == pytest.approx(curve, abs=0.02)
        assert (first["iteration"], first["revision"]) == (fitted["iterations"], 1)
        assert main([*map(str, ["replay", run, *client, "--speed", "100"])]) == 0
        until, batches = time.monotonic() + PATIENCE, fitted["iterations"]
        while (last := told(capsys, "query", *rates, *client))["revision"] < 1 + batches:
            assert time.monotonic() < until
        assert last["iteration"] == 2 * batches
    finally:
        process.terminate()
        log = process.communicate(timeout=PATIENCE)[1].decode()
    assert "auv/yaw: resumes after revision 1" in log
    assert not any(word in log for word in ("ERROR", "clock", "Traceback"))


def test_what_is_written_is_what_was_learned_with(
    capsys: pytest.CaptureFixture[str], run: Path, tmp_path: Path
) -> None:
    first, second = tmp_path / "first.yaml", tmp_path / "second.yaml"
    result = told(capsys, "fit", run, "--inertia", "350", "--write", first)
    config = read_config(first)
    assert (config.vehicle.name, config.prefix) == ("leng", "leng/yaw")
    for section in ("learner", "signals"):
        for name, value in result["settings"][section].items():
            found = getattr(config, "vehicle" if name in ("inertia", "rate_range") else section)
            if name in type(found).model_fields and name not in ("lateness", "gap"):
                assert json.loads(json_text(getattr(found, name))) == value
    told(capsys, "fit", run, "--config", first, "--inertia", "340", "--write", second, "--force")
    again = read_config(second)
    assert again.vehicle.inertia == 340.0
    assert (again.learner, again.signals) == (config.learner, config.signals)


MINE = """\
# mine
prefix: my/yaw   # keys
learner: {batch: 40}  # flow
vehicle:
  name: my
  # the hull's
  inertia: 300
state: kept
"""


def test_in_a_file_that_is_there_only_what_was_fitted_changes(
    capsys: pytest.CaptureFixture[str], run: Path, tmp_path: Path
) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(MINE, encoding="utf-8")
    assert main(["fit", str(run), "--inertia", "350", "--write", str(mine)]) == 0
    said = capsys.readouterr().out
    assert "batches of 40" in said
    assert "changed in " in said
    assert "vehicle.inertia" in said
    assert "prefix" not in said
    lines = mine.read_text(encoding="utf-8").splitlines()
    assert lines[:2] == MINE.splitlines()[:2]
    assert lines[2].startswith("learner: {batch: 40, gamma: ")
    assert lines[2].endswith("}  # flow")
    assert lines[3:7] == ["vehicle:", "  name: my", "  # the hull's", "  inertia: 350.0"]
    assert (tmp_path / "kept/my/yaw.sqlite").exists()
    before = mine.read_bytes()
    assert main(["fit", str(run), "--write", str(mine)]) == 2
    assert "kept/my/yaw.sqlite is there already; --force sets it aside" in capsys.readouterr().err
    assert main(["fit", str(run), "--write", str(mine), "--force"]) == 0
    assert "changed in" in (said := capsys.readouterr().out)
    assert ": nothing; " in said
    assert mine.read_bytes() == before
    assert (tmp_path / "kept/my/yaw.refused-1.sqlite").exists()


ABOUT_WRITE = "is about what --write FILE leaves"


@pytest.mark.parametrize(
    ("text", "words", "cure"),
    [
        (None, ["--write", "config.yaml", "--name", "a/b"], "--name: vehicle.name: a name has letters"),
        ("vehicle: {axis: surge}", ["--write", "config.yaml", "--axis", "yaw"], "list one in `learners`"),
        ("prefix: [", ["--write", "config.yaml"], "this is no YAML"),
        (None, ["--write", "."], "name a file in a folder that is there with --write"),
        (None, ["--name=x"], ABOUT_WRITE),
        (None, ["--state=x"], ABOUT_WRITE),
        (None, ["--force"], ABOUT_WRITE),
    ],
)
def test_what_cannot_be_left_is_said_before_the_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str | None,
    words: list[str], cure: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path("config.yaml").write_text(text, encoding="utf-8")
    assert main(["fit", "no_such_run.csv", "--inertia", "1", *words]) == 2
    assert cure in capsys.readouterr().err


def test_what_is_left_out_is_as_the_preset_has_it(tmp_path: Path) -> None:
    """A value that is Config's own is no default where a preset has another."""
    config = read_config(None, {"inputs": {"preset": "blueos"}})
    signals = config.signals.model_copy(update={"sample_period": Config().signals.sample_period})
    config = config.model_copy(update={"signals": signals})
    config_output.write(tmp_path / "rov.yaml", config, "")
    assert read_config(tmp_path / "rov.yaml") == config


@pytest.mark.parametrize("command", ["tune", "identify"])
def test_a_file_that_a_person_wrote_is_not_replaced(
    command: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    mine = tmp_path / "config.yaml"
    mine.write_text("prefix: leng/yaw  # mine\n")
    assert main([command, "no_such_run.csv", "--write", str(mine)]) == 2
    said = capsys.readouterr().err
    assert "config.yaml is not replaced, because incsvr did not write it; name another file with --write" in said
    assert mine.read_text() == "prefix: leng/yaw  # mine\n"
