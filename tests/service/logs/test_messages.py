"""What a newcomer types wrong with a log is answered by what to type, in the names of that log."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from service.cli.command_line import main
from service.inputs.units import intended_quantity
from tests.service import link
from tests.service.logs.dive import Dive, dive
from tests.service.logs.test_middleware import dive_bag

DIVE = dive(40.0)
DEGREES = np.degrees(1.0)
OTHERS = ("--column", "yaw_rate=gyro", "--column", "torque=push", "--column", "t=stamp")


def table(path: Path, names: str = "t,yaw_rate,torque", rate: float = 1.0, torque: float = 1.0) -> str:
    rows = zip(DIVE.time.tolist(), (rate * DIVE.rate).tolist(), (torque * DIVE.torque).tolist(), strict=True)
    path.write_text(f"{names}\n" + "".join(f"{t},{r},{tau}\n" for t, r, tau in rows), encoding="utf-8")
    return str(path)


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) == 2
    return capsys.readouterr().err


def flags_in(sentence: str) -> list[str]:
    """The first flag that a sentence says to type."""
    found = re.search(r"--column ('[^']+'|[^\s`;]+)", sentence)
    assert found is not None
    return shlex.split(found[0])


def test_degrees_are_said_with_the_flag_that_mends_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = table(tmp_path / "run.csv", "stamp,gyro,push", DEGREES)
    said = refused(capsys, "fit", path, "--inertia", "0.6", *OTHERS)
    assert "--column yaw_rate=gyro:deg/s" in said
    assert main(["inspect", path, *OTHERS, "--json", "-"]) == 0
    notes = json.loads(capsys.readouterr().out)["proposal"]["notes"]
    assert any("looks like deg/s and is read as rad/s: --column yaw_rate=gyro:deg/s" in note for note in notes)
    mended = [*OTHERS[2:], *flags_in(said)]
    assert main(["fit", path, "--inertia", "0.6", *mended]) == 0
    capsys.readouterr()
    assert main(["inspect", path, *mended]) == 0
    assert "degrees?" not in capsys.readouterr().out


@pytest.mark.parametrize("command", ["fit", pytest.param("trace", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("names", "columns", "flag"),
    [
        ("t,yaw_rate,torque", (), "--column torque=-torque"),
        ("stamp,gyro,push", (*OTHERS[:2], "--column", "torque=push*1.5:N m", *OTHERS[4:]), "'torque=-push*1.5:N m'"),
        ("stamp,gyro,push", (*OTHERS[:2], "--column", "torque=-push", *OTHERS[4:]), "--column torque=push"),
    ],
)
def test_a_wrong_sign_is_mended_by_what_is_said(
    tmp_path: Path,
    command: str,
    names: str,
    columns: tuple[str, ...],
    flag: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    turned = 1.0 if "torque=-push" in columns else -1.0
    path = table(tmp_path / "run.csv", names, torque=turned)
    said = refused(capsys, command, path, "--inertia", "0.6", *columns)
    assert flag in said
    mended = [*(word for pair in _without_torque(columns) for word in pair), *flags_in(said)]
    assert main([command, path, "--inertia", "0.6", *mended]) == 0


def _without_torque(columns: tuple[str, ...]) -> list[tuple[str, str]]:
    pairs = zip(columns[::2], columns[1::2], strict=True)
    return [pair for pair in pairs if not pair[1].startswith("torque=")]


def test_the_sign_of_thrusters_is_turned_by_the_yaw_rate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No column holds the torque: turning the yaw rate is what a flag can do."""
    turned = Dive(DIVE.time, -DIVE.rate, DIVE.command)
    path = str(link.as_tlog(tmp_path / "dive.tlog", link.in_order(link.parameters(), link.swum(turned))))
    said = refused(capsys, "fit", path, "--inertia", "0.6")
    assert "`--column yaw_rate=-ATTITUDE.yawspeed:rad/s` turns the yaw rate's" in said
    assert main(["fit", path, "--inertia", "0.6", *flags_in(said)]) == 0


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("YawRate", "yaw_rate"), ("rate", "yaw_rate"), ("torqe", "torque"), ("stamp", "t"),
    ],
)  # fmt: skip
def test_a_misspelt_quantity_is_no_silent_channel(
    tmp_path: Path, name: str, wanted: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = table(tmp_path / "run.csv", "stamp,gyro,push")
    said = refused(capsys, "inspect", path, "--column", f"{name}=gyro")
    assert f"there is no quantity {name}; did you mean {wanted}=gyro?" in said


@pytest.mark.parametrize("form", ["sqlite3", "mcap"])
def test_a_bag_without_its_metadata_is_read(tmp_path: Path, form: str, capsys: pytest.CaptureFixture[str]) -> None:
    bag = dive_bag(tmp_path, form)
    assert main(["inspect", str(bag), "--json", "-"]) == 0
    whole = json.loads(capsys.readouterr().out)
    (bag / "metadata.yaml").unlink()
    assert main(["inspect", str(bag), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["measured"] == whole["measured"]


def test_a_compressed_part_of_a_bag_says_what_to_give(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bag_0.db3.zstd"
    path.write_bytes(b"\x28\xb5\x2f\xfd" + bytes(100))
    assert "give the folder of its bag, with the metadata.yaml, or unpack it" in refused(capsys, "inspect", str(path))
    assert "no file in this folder is a log that can be read here (bag_0.db3.zstd)" in refused(
        capsys, "inspect", str(tmp_path)
    )


def test_a_configuration_of_inputs_alone_leaves_the_scales_to_the_recordings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(link.as_tlog(tmp_path / "dive.tlog", link.in_order(link.parameters(), link.swum(DIVE))))
    config = tmp_path / "inputs.yaml"
    config.write_text("inputs: {preset: blueos}\n", encoding="utf-8")
    results = []
    for words in ([], ["--config", str(config)]):
        assert main(["fit", path, "--inertia", "0.6", *words, "--json", "-"]) == 0
        results.append(json.loads(capsys.readouterr().out))
    assert results[0] == results[1]


CHANNELS = "yaw_rate depth_2 voltage2 thruster_3_speed armed roll sway_force rpm other.yaw_rate"


@pytest.mark.parametrize("name", CHANNELS.split())
def test_further_channels_are_welcome(name: str) -> None:
    assert intended_quantity(name, [name]) is None


def test_inspect_sees_degrees_by_the_heading_beside_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A yaw rate too slow to be seen by its size, and a heading in degrees beside a yaw rate in rad/s."""
    for slower, unit, said, not_said in (
        (0.02, 1.0, "yaw_rate looks like deg/s", "heading looks"),
        (1.0, DEGREES, "heading looks like deg and is read as rad: --column heading=heading:deg", "yaw_rate looks"),
    ):
        heading = unit * np.cumsum(0.05 * slower * DIVE.rate)
        rate = DIVE.rate if unit != 1.0 else slower * DEGREES * DIVE.rate
        path = tmp_path / "run.csv"
        np.savetxt(path, np.c_[DIVE.time, rate, DIVE.torque, heading % (unit * 2.0 * np.pi)], delimiter=",",
                   header="t,yaw_rate,torque,heading", comments="")  # fmt: skip
        assert main(["inspect", str(path)]) == 0
        printed = re.sub(r"\s+", " ", capsys.readouterr().out)
        assert said in printed
        assert not_said not in printed
