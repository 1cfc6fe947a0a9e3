"""One axis of a whole vehicle: read under its own names, told in its own words and units, traced as yaw is."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, BODY_YAW_RATE
from service.cli.command_line import main
from service.config.sources import read as read_config
from service.inputs.settings import Inputs
from service.logs.reading import LogDescription
from service.recordings.reading import Reading
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from tests.incsvr.test_coriolis import STEP, wandering

MASS, CORIOLIS = 60.0, 45.0
NAMES = ("surge", "sway", "yaw_rate", "heading", "surge_force", "sway_force", "torque")


def vehicle(seed: int, count: int = 1500) -> Recording:
    """60 v̇ + 30 v + 120 v|v| + 45 u r = Y in sway, beside a surge and a turn that wander."""
    random = np.random.default_rng(seed)
    surge, turn = wandering(random, count, 4.0, 0.4), wandering(random, count, 3.0, 0.3)
    force, water = np.repeat(random.uniform(-25.0, 25.0, count // 30), 30), wandering(random, count, 0.5, 0.5)
    sway = np.zeros(count)
    for k in range(count - 1):
        v = sway[k]
        for _ in range(4):
            pushed = force[k] + water[k] - 30.0 * v - 120.0 * v * abs(v) - CORIOLIS * surge[k] * turn[k]
            v += 0.25 * STEP / MASS * pushed
        sway[k + 1] = v
    time: Array = STEP * np.arange(count, dtype=np.float64)
    still = np.zeros(count)
    values = (surge, sway + random.normal(0.0, 0.002, count), turn, still, still, force, 5.0 * turn)
    return from_table(f"vehicle_{seed}.csv", time, dict(zip(NAMES, values, strict=True)))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("axes")
    for seed in (1, 2):
        write(folder / f"{seed}.csv", vehicle(seed))
    return [str(folder / "1.csv"), str(folder / "2.csv")]


def test_a_log_of_an_axis_keeps_the_names_of_the_body(tmp_path: Path) -> None:
    """Under names of others, of which a person says four: nothing is called as yaw, and nothing is lost."""
    whole, path = vehicle(3, 300), tmp_path / "log.csv"
    renamed = {f"{name}_logged": stream for name, stream in whole.own_streams.items()}
    write(path, replace(whole, own_streams=renamed))
    said = ("sway", "sway_force", "yaw_rate", "heading")
    columns = tuple(f"{name}={name}_logged" for name in said)
    found = Reading(LogDescription(columns, Inputs()), axis=AXES["sway"], learns=False).of_one(path)
    assert set(found.columns) == set(said)
    for name in said:
        np.testing.assert_array_equal(found.columns[name], whole.columns[name])
    assert found.places["sway_force"] == "sway_force_logged"
    heard = found.streams()
    assert set(heard) == {"yaw_rate", "torque", BODY_YAW_RATE}
    np.testing.assert_array_equal(heard["yaw_rate"][1], whole.columns["sway"])
    with pytest.raises(BadInput, match="--column sway=nothing: there is no nothing"):
        Reading(LogDescription(("sway=nothing", "sway_force=sway_force_logged"), Inputs()), axis=AXES["sway"]).of_one(
            path
        )


def test_coriolis_is_traced_in_sway_in_newtons(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    fitted, unseen = files
    assert main(["trace", fitted, "--validate", unseen, "--axis", "sway", "--inertia", "60", "--json", "-"]) == 0
    out, told = capsys.readouterr()
    found = json.loads(out)
    assert found["axis"] == "sway"
    assert [each["effect"] for each in found["effects"]] == ["coriolis:surge*yaw_rate"]
    assert found["effects"][0]["parameters"]["ratio"] == pytest.approx(CORIOLIS / MASS, rel=0.1)
    assert set(found["ignored_channels"]) == {"surge_force", "torque"}
    assert found["error"]["after"]["free_run_rmse"] < 0.5 * found["error"]["before"]["free_run_rmse"]
    assert any("the axis is coupled to others: surge*yaw_rate takes about" in note for note in found["notes"])
    assert "declared mass 60 kg" in told
    assert "m/s" in told
    assert not any(word in told for word in ("rad/s", "N m", "kg m²", "yaw rate"))


def test_without_an_inertia_it_says_how_to_get_one(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("trace", "fit"):
        assert main([command, files[0]]) == 2
        told = capsys.readouterr().err
        assert "--inertia estimate" in told
        assert "vehicle.inertia" in told
        assert "350" not in told


def test_fit_of_an_axis_takes_the_settings_of_its_own_learner(files: list[str], tmp_path: Path) -> None:
    """A configuration with a learner for each axis gives the learner of the asked axis, as its own file would."""
    sway = {"vehicle": {"axis": "sway", "inertia": 60, "rate_range": [-0.4, 0.4], "rate_limit": 2}}
    sway |= {"learner": {"gamma": 9.0, "C": 40.0, "epsilon": 1.5}}
    yaw = {"prefix": "auv/yaw", "vehicle": {"axis": "yaw", "inertia": 12, "rate_range": [-1, 1], "rate_limit": 3}}
    both, alone = tmp_path / "both.yaml", tmp_path / "alone.yaml"
    both.write_text(json.dumps({"prefix": "auv", "learners": {"yaw": yaw, "sway": sway}}), encoding="utf-8")
    alone.write_text(json.dumps(sway), encoding="utf-8")
    found = {}
    for config in (both, alone):
        result, written = tmp_path / f"{config.stem}.json", tmp_path / f"{config.stem}_written.yaml"
        words = ["--axis", "sway", "--config", str(config), "--json", str(result)]
        words += ["--write", str(written), "--state", str(tmp_path)]
        assert main(["fit", files[0], *words]) == 0
        found[config.stem] = json.loads(result.read_text(encoding="utf-8"))
        again = read_config(written)
        assert (again.vehicle.axis, again.learner.gamma, again.vehicle.rate_limit) == ("sway", 9.0, 2.0)
    assert found["both"]["curve"] == found["alone"]["curve"]
    assert found["both"]["inertia"] == 60.0
