"""The learners that a vehicle file stands for: one for each axis that was identified with an actuator.

They become values of the configuration, those of the first axis at its top and the others in `also`, so that `incsvr
config show` prints each. What the configuration says itself goes before what the file says.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.scaling import scaled_to
from incsvr.numerics import Array
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES, stream_of
from incsvr.plant.body import Coupled
from service.config.configuration import Config, merge, validate
from service.config.vehicle_file import read_values

RATE_LIMIT_FACTOR = 3.0
"""A velocity beyond so many times the fastest one of the file's data is no measurement."""
MAX_RATE_LIMIT = 50.0
"""The largest rate limit that the configuration takes [rad/s], [m/s]."""
MAX_TORQUE_LIMIT = 1e7
"""The largest torque limit that the configuration takes [N m], [N]."""
EFFORT_LIMIT_FACTOR = 20.0
"""An effort beyond so many times the damping at the fastest velocity is no measurement: one in another unit is."""
SLOWEST_DECAY_S = 10.0
"""A damping that was found to be next to nothing counts as one by which the velocity decays in this time [s]."""
SCALED = ("gamma", "C", "epsilon", "near_rate", "near_damping")
"""The settings of a learner that have the units of its axis."""
GRAVITY = 9.81
"""[m/s²]"""


@dataclass(frozen=True, slots=True)
class FileContent:
    """The part of a vehicle file that learners need. `incsvr.vehicle.Vehicle` holds all of it, and takes 60 MB to load.

    Attributes:
        name: of the vehicle, as the configuration takes it.
        axes: those that the model predicts, in the order of ν.
        learned: those of them with an actuator.
        mass: M (6, 6), zero where an axis is not predicted.
        terms: axis → term → its coefficient.
        fastest: axis → its fastest velocity in the data [m/s], [rad/s].
    """

    name: str
    axes: tuple[str, ...]
    learned: tuple[str, ...]
    mass: Array
    terms: Mapping[str, Mapping[str, float]]
    fastest: Mapping[str, float]

    @staticmethod
    def read(path: Path) -> FileContent:
        """The content of a file.

        Raises:
            BadInput: it is no vehicle file, or no axis of it has an actuator.
        """
        values = read_values(path)
        mass = np.zeros((6, 6))
        for pair, entry in values["mass_matrix"].items():
            row, column = (_place(axis) for axis in pair.split(","))
            mass[row, column] = mass[column, row] = float(entry["value"])
        terms = {
            axis: {name: float(term["value"]) for name, term in of_axis.items()}
            for axis, of_axis in values["terms"].items()
        }
        fastest = {axis: float(values["fastest"][axis]) for axis in AXES}
        axes = tuple(axis for axis in AXES if axis in values["axes"])
        learned = tuple(axis for axis in axes if axis in values["driven"])
        if not learned:
            raise BadInput(
                f"{path}: no axis of this vehicle has an actuator, so there is no damping to learn; identify it from a "
                "log that holds the efforts"
            )
        name = re.sub(r"[^A-Za-z0-9_.-]+", "-", values["name"])[:64]
        return FileContent(name, axes, learned, mass, terms, fastest)

    def inertia(self, axis: str) -> float:
        """M_ii [kg], [kg m²]."""
        return float(self.mass[_place(axis), _place(axis)])

    def term(self, axis: str, name: str) -> float:
        """The coefficient of a term; zero where the model has none."""
        return self.terms.get(axis, {}).get(name, 0.0)


def body_of_file(path: Path, axis: str) -> dict[str, Any]:
    """The values of the section `vehicle` that a vehicle file declares: mass matrix, weight and centre of gravity.

    Raises:
        BadInput: it is no vehicle file, or has no inertia of this axis.
    """
    vehicle = FileContent.read(path)
    if not vehicle.inertia(axis) > 0.0:
        raise BadInput(f"{path}: it has no inertia of {axis}, but of {', '.join(vehicle.axes)}; choose one with --axis")
    weights = {name: value for name, value in _weights(vehicle, axis).items() if value is not None}
    return {"mass_matrix": vehicle.mass.ravel().tolist(), **weights}


def with_axes_of_file(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a configuration, with a learner for each axis of its `vehicle.file`, if it names one.

    Raises:
        BadInput: the file is no vehicle file, or no axis of it has an actuator.
    """
    file, given = vehicle_file_of(values), values.get("also", ())
    if file is None or not _are_mappings(given):  # what `also` must be is said where it is checked
        return dict(values)
    vehicle = FileContent.read(Path(file))
    above, last = _place_of_prefix(values)
    wanted = [last, values["vehicle"].get("axis"), "yaw", *vehicle.learned]
    first = next(name for name in wanted if name in vehicle.learned)
    own, others = _by_axis(given, vehicle.learned)
    for_all = {name: values[name] for name in ("vehicle", "learner", "signals") if name in values}
    for_all["vehicle"] = {name: value for name, value in for_all["vehicle"].items() if name not in ("axis", "file")}
    found = {
        name: merge(merge({"prefix": f"{above}{name}", **_learner(vehicle, name)}, for_all), own.get(name, {}))
        for name in (first, *(name for name in vehicle.learned if name != first))
    }
    top = found.pop(first)
    also = [_differing(entry, top) for entry in found.values()]
    return {
        **values,
        **top,
        "vehicle": {**top["vehicle"], "file": str(file)},
        "also": [*also, *others],
        **_inputs(values, first, vehicle.learned),
    }


def vehicle_file_of(values: Mapping[str, Any]) -> str | Path | None:
    """The vehicle file that the values of a configuration name; None where they name none."""
    section = values.get("vehicle")
    file = section.get("file") if isinstance(section, Mapping) else None
    return file if isinstance(file, str | Path) else None


def _place(axis: str) -> int:
    return list(AXES).index(axis)


def _place_of_prefix(values: Mapping[str, Any]) -> tuple[str, str]:
    """The common begin of the prefixes of all axes, and the axis that the configured one ends with, or nothing."""
    prefix = str(values.get("prefix", Config.model_fields["prefix"].default))
    above, slash, last = prefix.rpartition("/")
    return (f"{above}{slash}", last) if last in AXES else (f"{prefix}/", "")


def _inputs(values: Mapping[str, Any], first: str, learned: tuple[str, ...]) -> dict[str, Any]:
    """The section `inputs` with thrusters that make the efforts of all axes that no channel brings, if it has some
    whose places are known."""
    inputs = values.get("inputs")
    thrusters = inputs.get("thrusters") if isinstance(inputs, Mapping) else None
    each = thrusters.get("each") if isinstance(thrusters, Mapping) else None
    if not isinstance(each, list | tuple) or not all(isinstance(one, Mapping) and one.get("position") for one in each):
        return {}
    channels = inputs.get("channels") or ()  # type: ignore[union-attr]
    further = [axis for axis in learned if axis != first and AXES[axis].effort not in channels]
    return {"inputs": merge(inputs, {"thrusters": {"axis": first, "also_along": further}})}  # type: ignore[arg-type]


def _are_mappings(given: Any) -> bool:
    """Whether this is a list of mappings."""
    return isinstance(given, list | tuple) and all(isinstance(entry, Mapping) for entry in given)


def _by_axis(
    also: Sequence[Mapping[str, Any]], learned: tuple[str, ...]
) -> tuple[dict[str, Mapping[str, Any]], list[Mapping[str, Any]]]:
    """The entries of `also` that speak of an axis of the file, by that axis, and those of other learners."""
    own: dict[str, Mapping[str, Any]] = {}
    others = []
    for entry in also:
        section = entry.get("vehicle")
        axis = section.get("axis") if isinstance(section, Mapping) else None
        if axis in learned and axis not in own:
            own[str(axis)] = entry
        else:
            others.append(entry)
    return own, others


def _differing(entry: Mapping[str, Any], top: Mapping[str, Any]) -> dict[str, Any]:
    """The values of an entry of `also` that differ from the top's."""
    found = {}
    for name, value in entry.items():
        above = top.get(name)
        if isinstance(value, Mapping) and isinstance(above, Mapping):
            value = _differing(value, above)
            if value:
                found[name] = value
        elif name not in top or value != above:
            found[name] = value
    return found


def _learner(vehicle: FileContent, axis: str) -> dict[str, Any]:
    """The settings of the learner of one axis, by the file."""
    fastest = float(f"{vehicle.fastest[axis]:.3g}")
    damping = _largest_damping(vehicle, axis, fastest)
    section = {
        "name": vehicle.name,
        "axis": axis,
        "mass_matrix": vehicle.mass.ravel().tolist(),
        "rate_range": [-fastest, fastest],
        "rate_limit": min(float(f"{RATE_LIMIT_FACTOR * fastest:.3g}"), MAX_RATE_LIMIT),
        "torque_limit": min(float(f"{EFFORT_LIMIT_FACTOR * damping:.3g}"), MAX_TORQUE_LIMIT),
        **_weights(vehicle, axis),
    }
    recorded = (*(AXES[name].rate for name in vehicle.axes), *ATTITUDE)
    restoring = validate({"vehicle": section}, {}).vehicle.restoring
    coupled = Coupled(AXES[axis], vehicle.mass, recorded, restoring)
    told = {stream_of(AXES[axis], AXES[name].rate) for name in vehicle.learned}
    settings = scaled_to(fastest, damping)
    return {
        "vehicle": section,
        "learner": {name: float(f"{getattr(settings, name):.3g}") for name in SCALED},
        "signals": {"channels": [name for name in coupled.streams if name not in told]},
    }


def _largest_damping(vehicle: FileContent, axis: str, fastest: float) -> float:
    """d at the fastest velocity [N], [N m]."""
    least = vehicle.inertia(axis) * fastest / SLOWEST_DECAY_S
    return max(vehicle.term(axis, "linear") * fastest + vehicle.term(axis, "quadratic") * fastest**2, least)


def _weights(vehicle: FileContent, axis: str) -> dict[str, Any]:
    """Weight, buoyancy and centre of gravity that make the file's restoring term of this axis.

    The file knows W − B (heave) and z_g W (roll, pitch) alone. With the centre of buoyancy at the origin, and B = W
    but for heave, the force is the file's whatever W is: it is taken for that of the mass along surge or heave.
    """
    term = vehicle.term(axis, "weight" if axis == "heave" else "righting")
    if not term:
        return {"weight": None, "buoyancy": None, "centre_of_gravity": [0.0, 0.0, 0.0]}
    weight = max(GRAVITY * vehicle.inertia("surge"), GRAVITY * vehicle.inertia("heave"), 2.0 * abs(term))
    if axis == "heave":
        return {"weight": weight, "buoyancy": weight - term, "centre_of_gravity": [0.0, 0.0, 0.0]}
    return {"weight": weight, "buoyancy": None, "centre_of_gravity": [0.0, 0.0, term / weight]}
