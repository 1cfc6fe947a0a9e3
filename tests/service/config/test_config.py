"""The configuration: what is wrong is said in one sentence, with the line, the variable or the flag."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest
import yaml

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.plant.axes import BODY_YAW_RATE
from incsvr.signals import SignalSettings
from service.bus.session import from_file
from service.cli.command_line import main
from service.config.config_writer import commented_yaml
from service.config.configuration import REMOVED, Config
from service.config.sources import add_config_arguments, from_arguments, read
from tests.conftest import ROOT


def test_the_defaults_are_those_of_the_mathematics() -> None:
    assert Config().learner_settings() == Settings()
    assert Config().signal_settings() == SignalSettings()


def test_the_file_of_the_repository_holds_the_defaults_commented() -> None:
    assert (ROOT / "config.yaml").read_text(encoding="utf-8") == commented_yaml(Config())
    assert read(ROOT / "config.yaml") == Config()


def test_every_value_says_what_it_is() -> None:
    values = yaml.safe_load(commented_yaml(Config()))
    assert values == Config().model_dump(mode="json")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("learner:\n  gamma: 10\n  epsilon: -1\n", "line 3: learner.epsilon"),
        ("learner:\n  gama: 10\n", "line 2: there is no learner.gama"),
        *(
            (f"{section}: {{{key}: 1}}\n", f"line 1: {section}.{key} left the configuration; leave it out: ")
            for section, key in (name.split(".") for name in REMOVED if name.count(".") == 1)
        ),
        ("also: [{prefix: b}]\n", "line 1: also left the configuration; leave it out: list every learner"),
        ("simulation: {seed: 1}\n", "line 1: simulation left the configuration; leave it out: `incsvr simulate` has"),
        *(
            (f"prefix: {prefix}\n", "line 1: prefix: a prefix is names with slashes between them")
            for prefix in ("a b", "a/../../b", "..", ".", "./a", "a/.", "a/..", "../a", "/a", "a//b", "a/")
        ),
        ("\n\nvehicle: {inertia: heavy}\n", "line 3: vehicle.inertia"),
        ("vehicle:\n  rate_range: [0.3, -0.3]\n", "line 1: vehicle: rate_range needs its lower end first"),
        (
            "vehicle:\n  mass_matrix: [1, 2, 3]\n",
            "line 2: vehicle.mass_matrix: the mass matrix has 3 entries; give its",
        ),
        (
            "vehicle:\n  mass_matrix: [1, 2, 3, 4, 5, x]\n",
            "line 2: vehicle.mass_matrix.5: Input should be a valid number",
        ),
        (
            "vehicle:\n  mass_matrix: [1, 2, 3, 4, 5, 0]\n",
            "line 1: vehicle: mass_matrix has 0 for yaw, the axis that is",
        ),
        (
            "vehicle:\n  mass_matrix: [1, 2, 3, 4, 5, 6]\n  inertia: 7\n",
            "and mass_matrix has 6 for yaw; leave out inertia",
        ),
        ("vehicle:\n  buoyancy: 300\n", "line 1: vehicle: buoyancy needs a weight; give weight [N]"),
        ("signals:\n  gap: 1.0\n", "line 1: signals: gap is longer than twice the smoothing"),
        ("bus:\n  listen: tcp/0.0.0.0:7447\n", "line 2: bus.listen: this listens on all interfaces"),
        *(
            (f"bus:\n  listen: {everywhere}:7447\n", "line 2: bus.listen: this listens on all interfaces")
            for everywhere in (
                "tcp/0",
                "tcp/0x0",
                "tcp/0.0",
                "tcp/*",
                "tls/[::]",
                "tcp/[::0]",
                "tcp/[0:0:0:0:0:0:0:0]",
                "tcp/[::ffff:0.0.0.0]",
            )
        ),
        ("bus:\n  listen: 7447\n", "line 2: bus.listen"),
        ("a: b: c\n", "line 1: this is no YAML"),
        ("- 1\n- 2\n", "the configuration is a list"),
        ("learners:\n  b:\n    vehicle: {inertia: -3}\n", "line 3: vehicle.inertia"),
        (
            "archive: {directory: x}\nlearners: {a: {prefix: a/b-c}, b: {prefix: a-b/c}}",
            "the archives of a/b-c and a-b/c have the same file names",
        ),
        ("learners: {a: {}, b: {vehicle: {inertia: 3}}}\n", "two learners share the prefix leng/yaw"),
        ("tracing:\n  proof: 500\n", "line 1: tracing: proof is more than half the window"),
        ("tracing: {live: true}\neffects: trace.json\n", "tracing.live finds the effects itself"),
        ("tracing: {live: true, window: 300, proof: 150}\nlearner: {batch: 200}\n", "390 s; it is 300 s"),
        ("learner:\n  C: .nan\n", "line 2: learner.C"),
    ],
)
def test_what_is_wrong_in_a_file_is_named_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, sentence: str
) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    assert main(["config", "check", str(path)]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1


def test_a_prefix_may_have_dots_within_its_names(tmp_path: Path) -> None:
    for prefix in ("a.b/.c/...", "rov7.v2/yaw"):
        assert read(None, {"prefix": prefix}).prefix == prefix


def test_a_good_file_is_said_to_be_good(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(
        "vehicle: {name: bluerov, inertia: 1}\nlearners: {a: {prefix: bluerov/yaw}, b: {prefix: bluerov/pitch}}\n"
    )
    assert main(["config", "check", str(path)]) == 0
    assert "good; the learner serves bluerov/yaw, bluerov/pitch" in capsys.readouterr().out


@pytest.mark.parametrize(
    "text",
    [
        "vehicle: {name: bluerov}\n",
        "inputs: {preset: ros2}\n",
        "learners: {yaw: {}, surge: {vehicle: {axis: surge}}}\n",
    ],
)
def test_no_other_vehicle_is_learned_by_lengs_inertia(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    for command in (["config", "check", str(path)], ["serve", "--config", str(path)]):
        assert main(command) == 2
        assert "is not configured, and the default is that of Leng; give vehicle.inertia" in capsys.readouterr().err


def test_variables_go_before_the_file_and_flags_before_both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "config.yaml"
    path.write_text("learner: {gamma: 1, C: 2, epsilon: 3}\n")
    monkeypatch.setenv("INCSVR_LEARNER__C", "20")
    monkeypatch.setenv("INCSVR_LEARNER__EPSILON", "30")
    parser = argparse.ArgumentParser()
    add_config_arguments(parser)
    args = parser.parse_args(["--config", str(path), "--set", "learner.epsilon=300", "--prefix", "a/b"])
    config = from_arguments(args)
    assert (config.learner.gamma, config.learner.C, config.learner.epsilon, config.prefix) == (1, 20, 300, "a/b")


def test_a_wrong_variable_and_a_wrong_flag_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    parser = argparse.ArgumentParser()
    add_config_arguments(parser)
    args = parser.parse_args(["--set", "learner.C=-1"])
    with pytest.raises(BadInput, match=r"--set learner.C: learner.C: Input should be greater than 0, not -1"):
        from_arguments(args)
    monkeypatch.setenv("INCSVR_LEARNER__GAMMA", "wide")
    with pytest.raises(BadInput, match=r"the variable INCSVR_LEARNER__GAMMA: learner.gamma"):
        read()
    monkeypatch.delenv("INCSVR_LEARNER__GAMMA")
    monkeypatch.setenv("INCSVR_LERNER__GAMMA", "1")
    with pytest.raises(BadInput, match="there is no lerner"):
        read()


def test_a_missing_file_and_a_wrong_zenoh_file_are_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="there is no such file"):
        read(tmp_path / "none.yaml")
    wrong = tmp_path / "zenoh.json5"
    wrong.write_text("{mode: 'nonsense'}")
    with pytest.raises(BadInput, match="is no Zenoh configuration"):
        from_file(wrong)


def test_the_example_configurations_are_good() -> None:
    for path in sorted((ROOT / "deploy").glob("*.yaml")):
        read(path)


def test_a_mass_matrix_says_the_inertia_of_each_axis(tmp_path: Path) -> None:
    rows = [[60.0 + 20.0 * row if row == column else 0.0 for column in range(6)] for row in range(6)]
    rows[1][5] = rows[5][1] = 3.0
    path = tmp_path / "config.yaml"
    channels = {"yaw": ["surge", "sway"], "surge": ["sway", BODY_YAW_RATE], "sway": ["surge", BODY_YAW_RATE]}
    learners = {axis: {"vehicle": {"axis": axis}, "signals": {"channels": others}} for axis, others in channels.items()}
    vehicle = {"name": "rov", "mass_matrix": rows}
    path.write_text(yaml.safe_dump({"prefix": "rov/yaw", "vehicle": vehicle, "learners": learners}, sort_keys=False))
    config = read(path)
    yaw, surge, sway = config.each()
    assert [each.vehicle.inertia for each in (yaw, surge, sway)] == [160.0, 60.0, 80.0]
    assert [each.prefix for each in (yaw, surge, sway)] == ["rov/yaw", "rov/surge", "rov/sway"]
    coupled = sway.coupled()
    assert coupled is not None
    assert (coupled.coupled_to, coupled.missing) == (("yaw_rate",), ("heave", "roll_rate"))
    assert read_text(commented_yaml(yaw, brief=True), tmp_path).vehicle == yaw.vehicle


def read_text(text: str, folder: Path) -> Config:
    (folder / "again.yaml").write_text(text)
    return read(folder / "again.yaml")
