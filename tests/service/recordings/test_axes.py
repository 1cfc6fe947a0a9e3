"""One axis of a whole vehicle: read under its own names, told in its own words and units, traced as yaw is."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, YAW
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.words import words_of
from incsvr.tracing.run import Run, check
from service.cli.command_line import main
from service.config.sources import read as read_config
from service.recordings.recording import Recording, of_axis
from service.recordings.recording_csv import read, write
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
    return Recording(f"vehicle_{seed}.csv", time, dict(zip(NAMES, values, strict=True)))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("axes")
    for seed in (1, 2):
        write(folder / f"{seed}.csv", vehicle(seed))
    return [str(folder / "1.csv"), str(folder / "2.csv")]


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


def test_fit_of_an_axis_says_its_words(files: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["fit", files[0], "--validate", files[1], "--axis", "surge", "--inertia", "60"])
    assert status == 2  # its force is zero throughout
    told = capsys.readouterr().err
    assert "too little motion" in told
    assert "rad/s" not in told
    assert "yaw" not in told


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


def test_a_whole_vehicle_is_read_as_one_of_its_axes(tmp_path: Path) -> None:
    whole = vehicle(3, 60)
    write(tmp_path / "whole.csv", whole)
    sway = read(tmp_path / "whole.csv", axis=AXES["sway"])
    np.testing.assert_array_equal(sway.columns["yaw_rate"], whole.columns["sway"])
    np.testing.assert_array_equal(sway.columns["torque"], whole.columns["sway_force"])
    np.testing.assert_array_equal(sway.displaced["yaw_rate"], whole.columns["yaw_rate"])
    assert set(sway.channels) == {"surge", "surge_force"}
    assert of_axis(whole, YAW) is whole
    with pytest.raises(BadInput, match="no column heave among"):
        read(tmp_path / "whole.csv", axis=AXES["heave"])


def test_limits_belong_to_the_axis(tmp_path: Path) -> None:
    """Eight is a speed of a boat and no yaw rate."""
    fast = {name: np.full(4, 8.0) for name in ("surge", "surge_force", "yaw_rate", "torque")}
    write(tmp_path / "fast.csv", Recording("fast.csv", np.arange(4, dtype=np.float64), fast))
    assert read(tmp_path / "fast.csv", axis=AXES["surge"], rate_limit=AXES["surge"].fastest).axis == AXES["surge"]
    with pytest.raises(BadInput, match="degrees per second"):
        read(tmp_path / "fast.csv")


def test_a_limit_is_a_setting(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A spinning vehicle: 8 rad/s is refused until somebody says that it is so."""
    time: Array = 0.1 * np.arange(600, dtype=np.float64)
    rate, torque = 8.0 * np.sin(time), 2.0 * np.cos(time)
    write(tmp_path / "fast.csv", Recording("fast.csv", time, {"yaw_rate": rate, "torque": torque}))
    run = Run("fast.csv", time, rate, torque)
    with pytest.raises(BadInput, match="or raise vehicle"):
        check([run])
    check([replace(run, rate_limit=10.0)])
    words = ["trace", str(tmp_path / "fast.csv")]
    assert main([*words, "--inertia", "1"]) == 2
    assert "if the vehicle really turns so fast, raise vehicle.rate_limit in a --config FILE" in capsys.readouterr().err
    (tmp_path / "fast.yaml").write_text("vehicle: {inertia: 1, rate_limit: 10}\n")
    main([*words, "--config", str(tmp_path / "fast.yaml")])
    assert "rate_limit" not in capsys.readouterr().err


@pytest.mark.parametrize("name", AXES)
def test_each_axis_has_words_of_its_own(name: str) -> None:
    """No word or unit of yaw is left in what is said of another axis; about one, units stay."""
    words, axis = words_of(AXES[name]), AXES[name]
    said = words.fill("{rate} {rate_unit} {effort} {effort_unit} {inertia} {inertia_unit} {linear} {quadratic}")
    assert (
        said
        == {
            "surge": "surge velocity m/s force N mass kg X_u X_u|u|",
            "sway": "sway velocity m/s force N mass kg Y_v Y_v|v|",
            "heave": "heave velocity m/s force N mass kg Z_w Z_w|w|",
            "roll": "roll rate rad/s torque N m inertia kg m² K_p K_p|p|",
            "pitch": "pitch rate rad/s torque N m inertia kg m² M_q M_q|q|",
            "yaw": "yaw rate rad/s torque N m inertia kg m² N_r N_r|r|",
        }[name]
    )
    assert (words.stream("yaw_rate"), words.stream("torque")) == (words.rate, words.effort)
    assert ("yaw" in " ".join(asdict(words).values())) == (axis == YAW)


@pytest.mark.parametrize(
    ("axis", "sentence", "told"),
    [
        ("yaw", "the torque is late against the yaw rate", "the torque is late against the yaw rate"),
        ("surge", "steps of torque until the yaw rate settles", "steps of force until the surge velocity settles"),
        ("sway", "the torque made 2 rad/s: set signals.torque", "the force made 2 m/s: set signals.torque"),
        ("roll", "the yaw rate is 2 rad/s, the torque 3", "the roll rate is 2 rad/s, the torque 3"),
    ],
)
def test_what_the_learning_says_is_told_in_the_words_of_an_axis(axis: str, sentence: str, told: str) -> None:
    assert in_words_of(AXES[axis], sentence) == told
