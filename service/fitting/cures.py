"""What mends a finding: the table id → cure, and the flag that reads a column of a log otherwise.

A test raises each of them, gives what it says, and sees that it is not said again.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import asdict

from incsvr.checks import Finding
from incsvr.plant.axes import Axis
from incsvr.plant.words import words_of
from service.recordings.recording import Recording

SIGN = "sign"
"""The kind of a finding that torque and yaw rate count in opposite directions, and its cure."""
CURES: Mapping[str, str] = {
    "inertia": "give --inertia I with the {moment_of_inertia} and its added mass in {inertia_unit} (from a model of "
    "the hull, a pendulum test, or the maker), --inertia estimate to estimate it from these recordings if they are "
    "open-loop runs, or --config FILE with vehicle.inertia",
    "inertia twice": "leave out one of the two",
    SIGN: "`{column}` turns the {turned}'s, --assume-sign uses both as recorded",
    "sign of a log": "turn one of them: {column}",
    "sign assumed": "leave out --assume-sign to see the cure",
    "radians": "give `{column}`",
    "milliseconds": "give `--column t=t:ms`, or declare the vehicle's own with --inertia",
    "scale": "scale it with `{column}`",
    "own inertia": "if the {effort} is in {effort_unit}, declare the vehicle's own with --inertia",
    "inertia or scale": "check the {inertia}, or the {effort}'s unit with `{column}`; declare the vehicle's own with "
    "--inertia",
    "pulses": "give the {moment} in {effort_unit} instead, or describe the thrusters in a --config FILE "
    "(inputs.thrusters)",
    "degrees": "it looks like degrees per second; give {column}",
    "unit of a log": "another unit; give {column}",
    "delay of a log": "export it again without, or leave this log out",
    "heading": "give {column}",
    "hands": "turn it: {column}",
    "place": "give it: --set 'inputs.velocity_place=[{ahead:.2f}, {aside:.2f}, 0]'",
    "frame": "give {column}--set inputs.velocity_frame={frame}{north}",
    "frame without heading": "record the heading, name it by --column heading=NAME, and give --set "
    "inputs.velocity_frame={frame}",
    "other velocities": "give --set vehicle.mass_matrix=…, learn over them with --set learner.inputs=…, or let `incsvr "
    "trace` find their effects",
    "smoothing": "give --set signals.smoothing={width:g}",
    "command": "give --set signals.torque=commanded",
}
"""Id → cure. The names in braces are `AxisWords`, and what `cure` is given."""
_FACTOR_AND_UNIT = re.compile(r"(\*[0-9.]+(?:[eE][+-]?[0-9]+)?)?(:[^:.]+)?$")


def cure(name: str, axis: Axis, **found: object) -> str:
    """The cure of this id in the words of an axis."""
    return CURES[name].format_map({**asdict(words_of(axis)), **found})


def with_cure(finding: Finding, recording: Recording) -> str:
    """The sentence of a finding on a recording, with its cure where the table has one."""
    if finding.kind != SIGN:
        return finding.sentence
    return f"{finding.sentence} ({cure_of_sign(recording)})"


def cure_of_sign(recording: Recording) -> str:
    """The flags that turn the sign of a recording's effort, or of its velocity, or declare that both are right."""
    axis, (name, column) = recording.axis, turned(recording, recording.axis)
    words = words_of(axis)
    return cure(SIGN, axis, column=column, turned=words.effort if name == axis.effort else words.rate)


def turned(recording: Recording, axis: Axis, several: bool = False) -> tuple[str, str]:
    """The stream of an axis whose sign is turned, and the flag: the effort, but where thrusters make it and no column
    holds it."""
    held = not recording.places or axis.effort in recording.places
    name = axis.effort if held or axis.rate not in recording.places else axis.rate
    return name, column(recording, name, "-", several)


def column(recording: Recording, name: str, change: str, several: bool = False) -> str:
    """The flag that changes one quantity of a log: `-` turns its sign, `*2` takes the stead of its factor, `:deg/s` of
    its unit.

    Args:
        several: whether other logs are read beside it, which the flag leaves as they are.
    """
    place = recording.places.get(name, "…" if recording.places else name)
    if change == "-":
        place = place.removeprefix("-") if place.startswith("-") else f"-{place}"
    elif change.startswith("*"):
        place = _FACTOR_AND_UNIT.sub(lambda found: f"{change}{found[2] or ''}", place, count=1)
    else:
        place = _FACTOR_AND_UNIT.sub(lambda found: f"{found[1] or ''}{change}", place, count=1)
    text = f"{recording.name}:{name}={place}" if several else f"{name}={place}"
    plain = text.replace("*", "")
    return f"--column {text if shlex.quote(plain) == plain else shlex.quote(text)}"
