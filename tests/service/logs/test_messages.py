"""What a newcomer types wrong with a log is answered by what to type, in the names of that log."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin

from service.cli.command_line import main
from service.inputs.quantities import intended_quantity
from tests.service import link
from tests.service.logs.dive import dive
from tests.service.logs.test_middleware import ros2_bag
from tests.service.logs.test_vehicles import ulog

DIVE = dive(60.0)
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


@pytest.mark.parametrize("form", [(), OTHERS])
def test_degrees_are_said_with_the_flag_that_mends_them(
    tmp_path: Path, form: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    path = table(tmp_path / "run.csv", "stamp,gyro,push" if form else "t,yaw_rate,torque", DEGREES)
    field = "gyro" if form else "yaw_rate"
    said = refused(capsys, "fit", path, "--inertia", "0.6", *form)
    assert f"--column yaw_rate={field}:deg/s" in said
    assert main(["inspect", path, *form, "--json", "-"]) == 0
    notes = json.loads(capsys.readouterr().out)["proposal"]["notes"]
    assert any(f"looks like deg/s and is read as rad/s: --column yaw_rate={field}:deg/s" in note for note in notes)
    others = [word for word in form if not word.startswith("yaw_rate=")]
    mended = [*(others[1:] if form else []), *flags_in(said)]
    assert main(["fit", path, "--inertia", "0.6", *mended]) == 0
    capsys.readouterr()
    assert main(["inspect", path, *mended]) == 0
    assert "degrees?" not in capsys.readouterr().out


def test_inspect_marks_degrees_and_prints_units(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", table(tmp_path / "run.csv", rate=DEGREES)]) == 0
    printed = capsys.readouterr().out
    assert "[rad/s: degrees?]" in printed
    assert "[N m]" in printed
    slow = tmp_path / "slow.csv"  # too slow to be seen by its size: the heading beside it shows it
    heading = np.cumsum(0.05 * 0.02 * DIVE.rate)
    rows = zip(DIVE.time, 0.02 * DEGREES * DIVE.rate, DIVE.torque, heading, strict=True)
    slow.write_text("t,yaw_rate,torque,heading\n" + "".join(f"{t},{r},{tau},{h}\n" for t, r, tau, h in rows))
    assert main(["inspect", str(slow)]) == 0
    assert "yaw_rate looks like deg/s" in re.sub(r"\s+", " ", capsys.readouterr().out)
    compass = tmp_path / "compass.csv"
    turned = np.degrees(np.cumsum(0.05 * DIVE.rate)) % 360.0
    rows = zip(DIVE.time, DIVE.rate, DIVE.torque, turned, strict=True)
    compass.write_text("t,yaw_rate,torque,heading\n" + "".join(f"{t},{r},{tau},{h}\n" for t, r, tau, h in rows))
    assert main(["inspect", str(compass)]) == 0
    printed = re.sub(r"\s+", " ", capsys.readouterr().out)
    assert "heading looks like deg and is read as rad: --column heading=heading:deg" in printed
    assert "yaw_rate looks" not in printed


def test_a_plain_recording_has_no_marks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", table(tmp_path / "run.csv")]) == 0
    assert "degrees?" not in capsys.readouterr().out


@pytest.mark.parametrize("command", ["fit", pytest.param("trace", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("names", "columns", "flag"),
    [
        ("t,yaw_rate,torque", (), "--column torque=-torque"),
        ("stamp,gyro,push", OTHERS, "--column torque=-push"),
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
    turned = dive(60.0).__class__(DIVE.time, -DIVE.rate, DIVE.command)
    path = str(link.as_tlog(tmp_path / "dive.tlog", link.in_order(link.parameters(), link.swum(turned))))
    said = refused(capsys, "fit", path, "--inertia", "0.6")
    assert "`--column yaw_rate=-ATTITUDE.yawspeed:rad/s` turns the yaw rate's" in said
    assert main(["fit", path, "--inertia", "0.6", *flags_in(said)]) == 0


@pytest.mark.slow
def test_a_scale_is_asked_of_the_logs_own_column(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    share = table(tmp_path / "share.csv", "stamp,gyro,push", torque=1.0 / 15.0)
    for command in ("trace", "fit"):
        assert main([command, share, "--inertia", "0.6", *OTHERS]) == 0
        assert "scale it with `--column torque=push*SCALE`" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("yawrate", "yaw_rate"), ("yaw_rat", "yaw_rate"), ("YawRate", "yaw_rate"), ("yaw-rate", "yaw_rate"),
        ("rate", "yaw_rate"), ("torqe", "torque"), ("tau", "torque"), ("stamp", "t"), ("headings", "heading"),
        ("surgeforce", "surge_force"), ("voltge", "voltage"), ("Heading", "heading"),
    ],
)  # fmt: skip
def test_a_misspelt_quantity_is_no_silent_channel(
    tmp_path: Path, name: str, wanted: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = table(tmp_path / "run.csv", "stamp,gyro,push")
    for command in (["fit", path, "--inertia", "0.6"], ["trace", path, "--inertia", "0.6"], ["inspect", path]):
        said = refused(capsys, *command, "--column", f"{name}=gyro")
        assert f"there is no quantity {name}; did you mean {wanted}=gyro?" in said


CHANNELS = (
    "yaw_rate mag_z pressure depth_2 voltage2 front_depth salinity thruster_3_speed armed motor_1 roll "
    "water_temperature sway_force rpm other.yaw_rate current_speed"
)


@pytest.mark.parametrize("name", CHANNELS.split())
def test_further_channels_are_welcome(name: str) -> None:
    assert intended_quantity(name, [name]) is None


def test_a_synonym_is_a_channel_beside_the_quantity_itself() -> None:
    assert intended_quantity("rate", ["yaw_rate", "rate"]) is None
    assert intended_quantity("rate", ["torque", "rate"]) == "yaw_rate"


def test_an_axis_says_its_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = table(tmp_path / "run.csv")
    for command in ("fit", "trace"):
        said = refused(capsys, command, path, "--inertia", "20", "--axis", "surge")
        assert "no surge velocity and no surge force found" in said
        assert "add --column surge=NAME --column surge_force=NAME" in said
        said = refused(capsys, command, path, "--inertia", "20", "--axis", "surge", "--column", "surge=yaw_rate")
        assert "no surge force found; add --column surge_force=NAME" in said
    # a column that bears the axis's name need not be said
    half = table(tmp_path / "half.csv", "stamp,surge,push")
    words = ["--inertia", "0.6", "--axis", "surge", "--column", "surge_force=push", "--column", "t=stamp"]
    assert main(["fit", half, *words]) == 0


def test_a_log_without_a_number_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "text.csv"
    path.write_text("name,remark\nhello,world\nfoo,bar\n", encoding="utf-8")
    for command in (["inspect", str(path)], ["fit", str(path), "--inertia", "1"]):
        assert "text.csv: no column of it holds numbers (only texts: name, remark)" in refused(capsys, *command)


@pytest.mark.parametrize("plugin", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_a_bag_without_its_metadata_is_read(
    tmp_path: Path, plugin: StoragePlugin, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = ros2_bag(tmp_path, plugin)
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


def test_px4_has_px4s_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The torque of a fast vehicle at 2 Hz."""
    path = tmp_path / "dive.ulg"
    path.write_bytes(ulog(DIVE))
    assert main(["inspect", str(path), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["proposal"]["preset"] == "px4"
    notes = " ".join(found["proposal"]["notes"])
    assert "ArduPilot" not in notes
    assert "SERVO_OUTPUT_RAW" not in notes


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
