"""docs/inputs.md: every configuration on it is one, and each preset listens as the page says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from incsvr.errors import BadInput
from service.bus.mapped_ingest import mapping
from service.config.sources import read
from service.inputs.input_mapper import InputMapper

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "inputs.md").read_text(encoding="utf-8")
CONFIGURATIONS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", CONFIGURATIONS)
def test_every_configuration_of_the_page_is_one(text: str, tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(text, encoding="utf-8")
    config = read(path)
    assert InputMapper(mapping(config)).keys
    routed = config.inputs.preset in ("blueos", "ros2", "keelson")
    assert (config.bus.connect == "tcp/127.0.0.1:7447") == routed
    assert (config.vehicle.name == "bluerov") == (config.inputs.preset == "blueos")


def test_the_preset_leaves_what_the_file_says(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text("inputs: {preset: blueos}\nbus: {listen: tcp/127.0.0.1:7447}\nvehicle: {inertia: 0.6}\n")
    config = read(path)
    assert (config.bus.connect, config.vehicle.inertia, config.vehicle.rate_range) == (None, 0.6, (-1.7, 1.7))


def test_thrusters_push_along_the_axis_that_is_learned(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    said = "inputs: {thrusters: {topic: u, command: N, each: [{position: [0, 0.5, 0], pushes: [1, 0, 0]}]}}\n"
    for axis in ("surge", "yaw"):
        path.write_text(f"{said}vehicle: {{axis: {axis}}}\n", encoding="utf-8")
        thrusters = read(path).inputs.thrusters
        assert thrusters is not None
        assert thrusters.axis == axis
    path.write_text("inputs: {preset: blueos}\nvehicle: {axis: surge}\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"blueos proposes inputs for yaw alone; with vehicle.axis surge describe"):
        mapping(read(path))
