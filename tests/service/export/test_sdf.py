"""The world of Gazebo against the description of SDFormat 1.10.

The tables hold the part of gazebosim/sdformat, sdf/1.10/*.sdf, that the export writes. SDFormat's own parser is in no
small package that is kept up. The one in Drake 1.51 read such worlds, and refused the first four of the faults below;
that siblings have different names is a rule of the specification since 1.7.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.plant.terms import Term
from incsvr.vehicle import Vehicle
from service.export.command import in_format
from tests.service.export.test_whole_vehicle import AHEAD, CROSS, OTHERS, vehicle_with

SHAPE = {"pose": "?", "geometry": "1"}
ADDED = [a + b for at, a in enumerate("xyzpqr") for b in "xyzpqr"[at:]]
CHILDREN: dict[str, dict[str, str]] = {
    "sdf": {"world": "*"},
    "world": {"gravity": "?", "physics": "+", "plugin": "*", "light": "*", "model": "*"},
    "physics": {"max_step_size": "1", "real_time_factor": "1"},
    "light": {"direction": "1"},
    "model": {"pose": "?", "link": "*", "plugin": "*"},
    "link": {"pose": "?", "inertial": "?", "collision": "*", "visual": "*"},
    "inertial": {"mass": "?", "inertia": "?", "fluid_added_mass": "?"},
    "inertia": {"ixx": "1", "iyy": "1", "izz": "1", "ixy": "?", "ixz": "?", "iyz": "?"},
    "fluid_added_mass": dict.fromkeys(ADDED, "?"),
    "collision": SHAPE,
    "visual": SHAPE,
    "geometry": {"box": "?"},
    "box": {"size": "1"},
}
"""How often a child may be there; the parser adds those which are needed and have a default."""
ATTRIBUTES = {
    "sdf": {"version"}, "physics": {"name", "type"}, "light": {"name", "type"}, "plugin": {"filename", "name"},
    **{each: {"name"} for each in ("world", "model", "link", "collision", "visual")},
}  # fmt: skip
NUMBERS = {"gravity": 3, "direction": 3, "pose": 6, "size": 3}
ALLOWED = {"": {0}, "1": {1}, "?": {0, 1}, "+": {1, 2}, "*": set(range(99))}


def faults(element: ET.Element) -> list[str]:
    """What SDFormat would refuse, in an element and those below it; a plugin's own content is the plugin's."""
    found = [f"attributes of {element.tag}"] * (set(element.attrib) != ATTRIBUTES.get(element.tag, set()))
    if element.tag == "plugin":
        return found
    if element.tag not in CHILDREN:
        values = [float(each) for each in (element.text or "").split()]
        return found + [f"numbers of {element.tag}"] * (len(values) != NUMBERS.get(element.tag, 1))
    count, allowed = Counter(child.tag for child in element), CHILDREN[element.tag]
    found += [f"{tag} in {element.tag}" for tag in count | allowed if count[tag] not in ALLOWED[allowed.get(tag, "")]]
    names = [child.get("name") for child in element if child.get("name") and child.tag != "plugin"]
    found += [f"names in {element.tag}"] * (len(set(names)) < len(names))
    return found + [each for child in element for each in faults(child)]


def refused(text: str) -> list[str]:
    root = ET.fromstring(text)
    moments = [float(root.findtext(f".//{name}") or 0.0) for name in ("ixx", "iyy", "izz")]
    return faults(root) + ["inertia"] * (2.0 * max(moments) > sum(moments))


WHOLE = vehicle_with({**CROSS, **AHEAD, **OTHERS, Term("roll", "righting"): 4.0, Term("heave", "weight"): 3.0})


def alone(axis: str, name: str) -> Vehicle:
    mass, terms = {(axis, axis): WHOLE.mass[axis, axis]}, {t: p for t, p in WHOLE.terms.items() if t.axis == axis}
    return replace(WHOLE, name=name, axes=(axis,), driven=(axis,), mass=mass, terms=terms)


@pytest.mark.parametrize("vehicle", [WHOLE, alone("yaw", 'fit, <"log--1">.json'), alone("surge", "world")])
def test_the_world_is_a_file_of_sdformat(vehicle: Vehicle) -> None:
    text, _ = in_format(vehicle, "gazebo")
    assert refused(text) == []
    assert re.search(r'<model name="(rov|fit_log_1_json|vehicle)">', text)
    space = np.prod([float(side) for side in text.partition("<size>")[2].partition("<")[0].split()])
    mass = float(text.partition("<mass>")[2].partition("<")[0])
    assert 1000.0 * space == pytest.approx(mass - (3.0 / 9.80665 if vehicle is WHOLE else 0.0), rel=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("pose>", "poze>", "poze in collision"),
        ("<xx>", "<ixx>1</ixx><xx>", "ixx in fluid_added_mass"),
        (' type="dart"', "", "attributes of physics"),
        ("<izz>", "<izz>9", "inertia"),
        ('"looks"', '"hull"', "names in link"),
        ("<size>", "<size>1 ", "numbers of size"),
    ],
)
def test_a_file_that_sdformat_refuses_is_found(old: str, new: str, fault: str) -> None:
    assert fault in refused(in_format(WHOLE, "gazebo")[0].replace(old, new))


def test_bodies_that_cannot_be_are_refused() -> None:
    with pytest.raises(BadInput, match="one is more than the others together"):
        in_format(WHOLE, "gazebo", 11.5, 0.25, (0.1, 0.1))
    with pytest.raises(BadInput, match="give more as --dry-mass"):
        in_format(WHOLE, "gazebo", 0.3)
