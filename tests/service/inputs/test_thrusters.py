"""The torque from what thrusters are told: curves, levers, directions, voltage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from incsvr.errors import BadInput
from incsvr.plant import Thruster as Formula
from incsvr.plant import thruster_torque
from service.cli.command_line import main
from service.inputs import ardusub
from service.inputs.measured_streams import measure
from service.inputs.settings import Axis, Inputs, Source, Thruster, Thrusters
from service.inputs.table import Table
from service.inputs.thrust import t200
from service.inputs.units import KGF_N

AXES: tuple[Axis, ...] = ("surge", "sway", "heave", "roll", "pitch", "yaw")
TIME = np.arange(0.0, 5.0, 0.1, dtype=np.float64)


def torque(settings: Thrusters, **columns: Any) -> Any:
    """The torque that is made of columns of one table."""
    given = {name: np.asarray(values, dtype=np.float64) * np.ones(TIME.size) for name, values in columns.items()}
    table = Table(TIME, {"r": np.sin(TIME), **given}, {})
    channels = {"surge": Source(topic="x", field="surge")} if "surge" in columns else {}
    inputs = Inputs(yaw_rate=Source(topic="x", field="r"), thrusters=settings, channels=channels)
    found = measure(inputs, {"x": table})
    return found.streams["torque"][1], found.notes


def one(**given: Any) -> Thrusters:
    return Thrusters.model_validate({"topic": "x", "each": [{"field": "u", "arm": 0.5}], **given})


def test_the_t200_is_the_makers_at_its_ends_and_silent_in_its_band() -> None:
    pulses = np.array([400.0, -400.0, 27.0, -27.0, 500.0])
    np.testing.assert_allclose(
        t200(pulses, np.full(5, 16.0)), KGF_N * np.array([5.25, -4.07, 0.0, 0.0, 5.25]), rtol=1e-12
    )
    np.testing.assert_allclose(t200(np.array([400.0]), np.array([15.0])), KGF_N * (4.53 + 5.25) / 2.0)


def test_the_formula_of_section_iv_a() -> None:
    """K₁ω|ω| + K₂v|ω|, as the plant has it."""
    speeds, water = 40.0 * np.sin(TIME), 0.4 + 0.1 * TIME
    wanted = thruster_torque((Formula(0.5, 0.02, -0.03),), (speeds,), (water,))
    got, _ = torque(one(command="rad/s", curve="quadratic", full=0.02, inflow=-0.03), u=speeds, surge=water)
    np.testing.assert_allclose(got, wanted)
    turns, _ = torque(one(command="rpm", curve="quadratic", full=0.02), u=speeds * 30.0 / np.pi)
    np.testing.assert_allclose(turns, thruster_torque((Formula(0.5, 0.02, 0.0),), (speeds,), (water,)))


@pytest.mark.parametrize(
    ("given", "command", "newtons"),
    [
        ({"command": "N"}, 7.0, 7.0),
        ({"command": "fraction", "curve": "linear", "full": 40.0}, -0.5, -20.0),
        ({"command": "fraction", "curve": "quadratic", "full": 40.0}, -0.5, -10.0),
        ({"command": "pwm", "curve": "linear", "full": 40.0}, 1600.0, 10.0),
        ({"command": "pwm", "voltage": 16.0}, 1900.0, 5.25 * KGF_N),
        ({"command": "pwm", "voltage": 16.0}, 0.0, 0.0),
    ],
)
def test_commands_of_every_kind(given: dict[str, Any], command: float, newtons: float) -> None:
    np.testing.assert_allclose(torque(one(**given), u=command)[0], 0.5 * newtons)


@pytest.mark.parametrize("command", ["rpm", "rad/s"])
@pytest.mark.parametrize("curve", ["linear", "t200"])
def test_a_curve_of_pulses_is_refused_where_rotors_turn(
    command: str, curve: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = f", curve: {curve}"
    config = tmp_path / "config.yaml"
    each = "each: [{field: u, arm: 0.5}]"
    text = f"inputs: {{thrusters: {{topic: x, command: {command}{said}, {each}}}}}\nvehicle: {{inertia: 40.0}}\n"
    config.write_text(text, encoding="utf-8")
    assert main(["config", "check", str(config)]) == 2
    told = capsys.readouterr().err
    assert f"curve is {curve}, which belongs to pwm and fraction" in told
    assert f"with command {command} give curve: quadratic, with full in N s²/rad²" in told
    config.write_text(text.replace(said, ""), encoding="utf-8")
    assert main(["config", "check", str(config)]) == 0
    thrusters = Thrusters.model_validate({"topic": "x", "command": command, "each": [{"field": "u", "arm": 0.5}]})
    assert thrusters.curve == "quadratic"


def test_a_curve_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "thrust.csv"
    path.write_text("pwm,newtons\n1100,-40\n1500,0\n1900,50\n", encoding="utf-8")
    np.testing.assert_allclose(torque(one(command="pwm", curve=str(path)), u=1700.0)[0], 12.5)
    path.write_text("pwm,newtons\n1900,50\n1100,-40\n", encoding="utf-8")
    with pytest.raises(BadInput, match="rises in the first"):
        torque(one(command="pwm", curve=str(path)), u=1700.0)


def test_position_and_direction_make_the_lever() -> None:
    """A stern thruster that pushes to starboard, 1.25 m behind: it turns the bow to port."""
    stern = Thruster(field="u", position=(-1.25, 0.0, 0.0), pushes=(0.0, 2.0, 0.0))
    straight = np.zeros(1)
    assert stern.share("yaw", straight) == -1.25
    port = Thruster(field="u", position=(0.3, -0.2, 0.1), pushes=(1.0, 0.0, 0.0))
    assert [port.share(axis, straight)[0] for axis in AXES] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.1, 0.2])
    with pytest.raises(ValidationError, match="give either its arm"):
        Thruster(field="u")


def test_an_outboard_turns_the_boat_by_its_angle() -> None:
    """Pushing ahead at 2 m behind, turned by an angle: N = −2 sin α F, and along the bow cos α F."""
    angle = np.degrees(0.5 * np.sin(TIME))
    for axis, wanted in (("yaw", -2.0 * np.sin(0.5 * np.sin(TIME))), ("surge", np.cos(0.5 * np.sin(TIME)))):
        each = {"field": "u", "position": [-2.0, 0.0, 0.0], "pushes": [1.0, 0.0, 0.0]}
        turned = {**each, "turned_by": {"topic": "x", "field": "angle", "unit": "deg"}}
        got, _ = torque(one(command="N", axis=axis, each=[turned]), u=30.0, angle=angle)
        np.testing.assert_allclose(got, 30.0 * wanted)
    with pytest.raises(ValidationError, match="what is turned by an angle needs its position"):
        Thruster.model_validate({"field": "u", "arm": 1.0, "turned_by": {"topic": "x"}})


def test_the_measured_voltage_counts_and_a_missing_one_is_said() -> None:
    battery = Source(topic="x", field="volts", unit="mV")
    full, notes = torque(one(command="pwm", measured_voltage=battery), u=1900.0, volts=12000.0)
    np.testing.assert_allclose(full, 0.5 * 3.71 * KGF_N)
    assert not notes
    _, notes = torque(one(command="pwm"), u=1900.0)
    assert notes == (
        "the battery's voltage is unknown: the thrust is computed for 16 V (--column voltage=NAME gives it)",
    )


def test_a_frame_by_the_vehicles_parameters() -> None:
    told = {"FRAME_CONFIG": 1.0, "MOT_2_DIRECTION": -1.0, "SERVO7_FUNCTION": 34.0, "SERVO2_FUNCTION": 0.0}
    found = ardusub.thrusters(told, 1, lambda output: ("u", f"servo{output}_raw"))
    assert [each.field for each in found] == ["servo1_raw", "servo7_raw", "servo3_raw", "servo4_raw"]
    assert [each.direction for each in found] == [1, -1, 1, 1]
    assert [each.arm for each in found] == [0.189, -0.189, -0.189, 0.189]
