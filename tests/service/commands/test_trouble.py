"""Logs with the troubles that people had in public: read, or refused with the true cause and a cure that is tried."""

from __future__ import annotations

import gzip
import json
import re
import shlex
import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest

from incsvr.checks.filtered_export import filtered_export
from incsvr.numerics import Array
from service.cli.command_line import main
from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from tests.service.commands.test_each_log import FLAGS, JULY, JUNE, MAY, STEP_S, saved

INERTIA = ("--inertia", "0.6")


def unpacked(source: Path, folder: Path) -> Path:
    """A file of a trouble, or what is in it."""
    if source.name.endswith(".tar.gz"):
        with tarfile.open(source) as archive:
            archive.extractall(folder, filter="data")
        return folder / source.name.removesuffix(".tar.gz")
    if source.suffix == ".gz":
        (folder / source.stem).write_bytes(gzip.decompress(source.read_bytes()))
        return folder / source.stem
    shutil.copy(source, folder / source.name)
    return folder / source.name


def curve(path: Path) -> tuple[float, float]:
    """The coefficients of a result of `fit`."""
    found = json.loads(path.read_text(encoding="utf-8"))["coefficients"]
    return found["N_r"]["estimate"], found["N_r|r|"]["estimate"]


@pytest.mark.parametrize(
    "file",
    [
        "K10_pause/pause_600_s.csv",
        "K4_clocks_of_two_speeds/half_speed.tar.gz",
        "K6_imu_without_rate/not_a_number_first.tar.gz",
        "K5_tables/clock_back_an_hour.csv",
        "K5_tables/past_midnight.csv",
        "K5_tables/quoted_comma.csv",
        "K5_tables/t_is_a_date.csv",
        "K5_tables/units_row.csv",
    ],
)
def test_it_is_read(trouble: Path, tmp_path: Path, file: str) -> None:
    """d(1) is 2.2 N m."""
    path, result = unpacked(trouble / file, tmp_path), tmp_path / "result.json"
    assert main(["fit", str(path), *INERTIA, "--json", str(result)]) == 0
    linear, quadratic = curve(result)
    assert linear + quadratic == pytest.approx(2.2, rel=0.03)


@pytest.mark.parametrize(
    ("files", "words", "sentence", "mended"),
    [
        (["K1_hands_differ/sway_to_port.csv"], ["identify"], "sway counts in the other direction", True),
        (["K1_hands_differ/yaw_to_port.csv"], ["identify"], "sway counts in the other direction", True),
        (["K2_dvl_ahead_of_centre/dvl_0.4_m_ahead.csv"], ["identify"], "a place 0.40 m ahead of", True),
        (["K8_velocity_north_east/north_east.csv"], ["identify"], "to the north and east", True),
        (
            ["may.csv", "june_sign.csv", "july.csv"],
            ["compare"],
            "june_sign.csv: yaw torque and yaw rate count in",
            True,
        ),
        (["may.csv", "june_filtered.csv", "july.csv"], ["compare"], "june_filtered.csv: the yaw rate is 0.06 s", False),
        (["may.csv", "june_sign.csv"], ["fit", *INERTIA], "june_sign.csv: yaw torque and yaw rate count in", True),
        (["may.csv", "june_sign.csv"], ["trace", *INERTIA], "june_sign.csv: yaw torque and yaw rate count in", True),
        (["K6_imu_without_rate/on_its_side.tar.gz"], ["fit", *INERTIA], "what turns is /imu/data.angular", True),
        (["K7_two_senders_one_name/zeros_between.tar.gz"], ["fit", *INERTIA], "two senders on /thrust", False),
        (["K7_two_senders_one_name/zeros_between.tar.gz"], ["trace", *INERTIA], "two senders on /thrust", False),
        (
            ["K12_assumed_directions/no_parameters_cancels.tlog.gz"],
            ["fit", *INERTIA],
            "incsvr fit: the vehicle has not sent FRAME_CONFIG and others: assumed a BlueROV2 (frame 1,",
            True,
        ),
    ],
)
@pytest.mark.slow
def test_it_is_refused_with_its_cause_and_the_first_cure_is_tried(
    trouble: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    files: list[str],
    words: list[str],
    sentence: str,
    mended: bool,
) -> None:
    """After the cure the command succeeds, or says something else."""
    folder = trouble if "/" in files[0] else trouble / "K3_dives_not_checked"
    paths = [str(unpacked(folder / file, tmp_path)) for file in files]
    assert main([words[0], *paths, *words[1:]]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    cure = FLAGS.search(said)
    assert (cure is not None) == mended
    if cure is not None:
        status = main([words[0], *paths, *words[1:], *shlex.split(cure[0])])
        assert sentence not in capsys.readouterr().err
        assert status == 0 or words[0] == "fit"


@pytest.mark.slow
def test_marks_of_no_measurement_and_dives_out_of_order(
    trouble: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identify", str(trouble / "K11_invalid_velocity/one_sample_in_a_hundred.csv")]) == 0
    said = capsys.readouterr().out
    assert "surge is -32.768 in 7 of 700 samples" in said
    assert re.search(r"surge\n  effective inertia +2[45]\.", said)
    dives = sorted((trouble / "K3b_dives_out_of_order").glob("*.csv"))
    assert main(["compare", *map(str, dives), "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert found["order"] == "in the order of their stamps, which is not the order in which they were given"
    assert {row["dive"] for row in found["rows"] if row["changed"]} == {"dive3.csv"}


def test_too_few_means_are_refused_with_their_cause(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [
        f"{t},{r},{u}"
        for t, r, u in zip(TIME[::20], averaged(MAY["yaw_rate"], 20), averaged(MAY["torque"], 20), strict=True)
    ]
    (tmp_path / "means.csv").write_text("\n".join(["t,yaw_rate,torque", *lines]), encoding="utf-8")
    assert main(["fit", str(tmp_path / "means.csv"), *INERTIA]) == 2
    said = capsys.readouterr().err
    assert "incsvr fit: means.csv: the yaw rate comes every 1 s, within which the vehicle settles" in said
    assert "damping samples, but one batch needs 50" in said


def test_means_of_a_database_are_remarked(trouble: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(trouble / "K9_filtered_exports/means_of_0.5_s.csv"), *INERTIA]) == 0
    assert "means or thinned samples, which do not show its acceleration; export the raw" in capsys.readouterr().out


TIME: Array = np.asarray(STEP_S * np.arange(MAY["torque"].size), dtype=np.float64)
EVERY = TIME[::10]


def averaged(values: Array, count: int) -> Array:
    return np.asarray(values[: values.size // count * count].reshape(-1, count).mean(axis=1))


def clean(torque: Array) -> Array:
    """The motion under a torque, as a simulator has it."""
    rate = np.zeros(torque.size)
    for k in range(1, torque.size):
        push = torque[k - 1] - 0.6 * rate[k - 1] - 1.6 * rate[k - 1] * abs(rate[k - 1])
        rate[k] = rate[k - 1] + STEP_S * push / 0.6
    return rate


def both_ways(values: Array, width: int) -> Array:
    kernel = np.ones(2 * width + 1) / (2 * width + 1)
    return np.asarray(np.convolve(np.pad(values, width, mode="edge"), kernel, "valid"), dtype=np.float64)


@pytest.mark.parametrize(
    ("rate", "torque", "sentence"),
    [
        ((TIME, MAY["yaw_rate"]), (TIME, MAY["torque"]), None),
        ((TIME, both_ways(MAY["yaw_rate"], 3)), (TIME, MAY["torque"]), "filtered both ways"),
        ((TIME, MAY["yaw_rate"]), (TIME, MAY["torque"][np.maximum(np.arange(TIME.size) - 2, 0)]), "stamps are late"),
        ((TIME, MAY["yaw_rate"]), (TIME, np.interp(TIME, EVERY, MAY["torque"][::10])), "resampled by lines"),
        ((TIME, np.interp(TIME, EVERY, MAY["yaw_rate"][::10])), (TIME, MAY["torque"]), "{rate} has only straight"),
        ((TIME, np.round(np.interp(TIME, TIME[::4], MAY["yaw_rate"][::4]), 4)), (TIME, MAY["torque"]), "{rate} has"),
        (
            (TIME, np.repeat(MAY["yaw_rate"][::4], 4)[: TIME.size]),
            (TIME, MAY["torque"]),
            "repeats each of its values 4",
        ),
        ((TIME, np.round(clean(MAY["torque"]), 4)), (TIME, MAY["torque"]), None),
        ((TIME, clean(np.repeat(MAY["torque"][::40], 40)[: TIME.size])), (TIME, np.sin(TIME)), None),
        ((EVERY, averaged(MAY["yaw_rate"], 10)), (EVERY, averaged(MAY["torque"], 10)), "means or thinned samples"),
        ((TIME, MAY["yaw_rate"]), (TIME, 5.0 * np.sin(0.3 * TIME)), None),
        ((TIME, MAY["yaw_rate"]), (TIME, np.clip(9.0 * np.sin(0.5 * TIME), -4.0, 4.0)), None),
    ],
)
def test_filtered_and_resampled_exports(
    rate: tuple[Array, Array], torque: tuple[Array, Array], sentence: str | None
) -> None:
    found = filtered_export(rate, torque)
    assert found is None if sentence is None else found is not None and sentence in found


@pytest.mark.parametrize("dive", [MAY, JUNE, JULY], ids=["may", "june", "july"])
@pytest.mark.parametrize("jitter", [0.0, 0.02])
def test_a_sound_dive_of_a_quick_vehicle_is_not_blamed(tmp_path: Path, dive: dict[str, Array], jitter: float) -> None:
    """Its stamps are late by up to some milliseconds [s], as times of arrival are."""
    path, result = tmp_path / "dive.csv", tmp_path / "result.json"
    time = TIME + jitter * np.random.default_rng(650_003).random(TIME.size)
    write(path, from_table("dive", time, dict(dive)))
    assert main(["fit", str(path), *INERTIA, "--json", str(result)]) == 0
    found = json.loads(result.read_text(encoding="utf-8"))
    assert found["put_aside"] == 0
    assert not [remark for remark in found["remarks"] if not remark.startswith("smoothing over")]


def test_decimal_commas_of_numbers_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(saved(tmp_path, "may.csv", MAY))
    (tmp_path / "config.yaml").write_text("vehicle:\n  inertia: 0,6\n", encoding="utf-8")
    for flags in (("--inertia", "0,6"), ("--set", "vehicle.inertia=0,6"), ("--config", str(tmp_path / "config.yaml"))):
        assert main(["fit", path, *flags]) == 2
        assert "its decimal mark is a comma, as in some locales: write 0.6" in capsys.readouterr().err
