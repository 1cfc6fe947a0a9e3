"""`incsvr inspect LOG --plot FILE`: a picture of the streams that would be learned from."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from service.cli.command_line import main
from tests.service import link
from tests.service.logs.test_whose import DIVE, written
from viewer.log_plot import MAX_PANELS, of_log


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("log")
    return written(folder, "tlog", link.parameters(), link.swum(DIVE, armed_from=0.0))


def test_a_log_is_drawn_into_a_file_of_any_kind(log: Path, tmp_path: Path) -> None:
    for name in ("log.png", "log.svg"):
        assert main(["inspect", str(log), "--plot", str(tmp_path / name)]) == 0
    assert np.asarray(Image.open(tmp_path / "log.png").convert("L")).std() > 10.0
    assert (tmp_path / "log.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_streams_of_a_kind_share_a_panel_and_a_pause_breaks_a_line() -> None:
    time = np.concatenate((np.arange(0.0, 10.0, 0.1), np.arange(20.0, 30.0, 0.1)))
    named = ("yaw_rate", "roll_rate", "torque", "depth", "thruster_1_pwm", "thruster_2_pwm", "mag_x", "mag_y")
    streams = {name: (time, np.sin(time) + number) for number, name in enumerate(named)}
    units = {"yaw_rate": "rad/s", "roll_rate": "rad/s", "torque": "N m", "depth": "m"}
    figure = of_log("dive", streams, units, ((5.0, 25.0),))
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["turn rate\n[rad/s]", "torque\n[N m]", "depth\n[m]", "thruster pulse", "mag"]
    yaw = figure.axes[0].lines[0].get_ydata()
    np.testing.assert_array_equal(yaw[np.isfinite(yaw)], streams["yaw_rate"][1])
    assert np.count_nonzero(np.isnan(yaw)) == 1
    assert [patch.get_x() for patch in figure.axes[1].patches] == [0.0, 25.0]
    assert [text.get_text() for text in figure.axes[3].get_legend().get_texts()] == ["1", "2"]


def test_what_has_no_panel_is_named_and_stamps_since_1970_are_a_date() -> None:
    time = np.linspace(1.7e9, 1.7e9 + 9.9, 100)
    figure = of_log("dive", {f"channel{k}": (time, time) for k in range(MAX_PANELS + 2)}, {}, ())
    assert figure.axes[0].get_title(loc="left") == "dive; grey: disarmed; not drawn: channel9, channel10"
    assert figure.axes[-1].get_xlabel() == "time [s] since 2023-11-14 22:13:20 UTC"
    assert figure.axes[-1].get_xlim() == pytest.approx((0.0, 9.9))


@pytest.mark.parametrize(
    ("file", "sentence"), [("log.xyz", "cannot be written"), ("none/log.png", "name a file such as log.png")]
)
def test_a_file_that_cannot_be_is_one_sentence(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str, sentence: str
) -> None:
    assert main(["inspect", str(log), "--plot", str(tmp_path / file)]) == 2
    assert sentence in capsys.readouterr().err


def test_without_matplotlib_the_extra_is_named(log: Path, tmp_path: Path) -> None:
    (tmp_path / "matplotlib.py").write_text("raise ModuleNotFoundError(name='matplotlib')\n")
    program = "import sys; from service.cli.command_line import main; sys.exit(main())"
    ran = subprocess.run(
        [sys.executable, "-c", program, "inspect", str(log), "--plot", "log.png"],
        capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert ran.returncode == 2
    assert ran.stderr.count("\n") == 1
    assert "plots need matplotlib, which is not installed: pip install '.[report]'" in ran.stderr


def test_the_viewer_names_what_draws_a_log(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", str(log)]) == 2
    assert f"`incsvr inspect {log} --plot FILE`" in capsys.readouterr().err
