"""A whole vehicle as elements of simulators' own files. What an element cannot hold stands in a comment before it.

Signs and names were read in each tool's documentation and source: gz-sim, systems/hydrodynamics/Hydrodynamics.hh, .cc
and HydrodynamicsUtils.hh; SDFormat, inertial.sdf; UUV Simulator, HydrodynamicModel.cc (HMFossen); Stonefish,
docs/bodies.rst and docs/actuators.rst. All count hydrodynamic derivatives, negative where they oppose the motion.
UUV Simulator and Stonefish count ahead, to starboard and down, as SNAME does; Gazebo ahead, to port and up.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES
from incsvr.plant.terms import RIGHTING, Term
from incsvr.vehicle import Vehicle
from service.export.fragment import fragment
from service.export.rigid_body import RigidBody
from service.export.vehicle_remarks import STANDARD_GRAVITY, vehicle_remarks

FORCES, SPEEDS = "xyzkmn", "UVWPQR"
"""Letters of SNAME, as Gazebo's elements have them."""
PAIRS = [(row, column) for row in range(6) for column in range(row, 6)]
MASSES = "xyzpqr"
"""Letters of the rows and columns of an added mass in SDFormat."""
TURNED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""The signs of ν between axes to starboard and down, and axes to port and up."""


def gazebo(vehicle: Vehicle, body: RigidBody, link: str, flu: bool) -> tuple[str, list[str]]:
    """The link's <inertial> with its <fluid_added_mass>, and the Hydrodynamics plugin of gz-sim; and the remarks.

    Args:
        flu: whether the vehicle file counts to port and up already.
    """
    sign = np.ones(6) if flu else TURNED
    added = body.added * np.outer(sign, sign)
    water = [f"    <{MASSES[a]}{MASSES[b]}>{_n(added[a, b])}</{MASSES[a]}{MASSES[b]}>" for a, b in PAIRS if added[a, b]]
    # The plugin's names are not symmetric: each entry of its matrix is read by itself.
    own = [
        f"  <{FORCES[a]}Dot{SPEEDS[b]}>{_n(-added[a, b])}</{FORCES[a]}Dot{SPEEDS[b]}>"
        for a in range(6)
        for b in range(6)
        if added[a, b]
    ]
    terms = [
        f"  <{name}>{_n(-p.value * _flips(term, sign))}</{name}>"
        for term, p in vehicle.terms.items()
        if (name := _gazebo_name(term)) is not None
    ]
    remarks = [
        *vehicle_remarks(vehicle, body, lambda term: _gazebo_name(term) is not None, flu),
        "Axes are Gazebo's: ahead, to port, up.",
        "The added mass is in <fluid_added_mass> (SDFormat 1.10, gz-sim 8, the physics engine DART), with the Coriolis "
        "forces that follow from it. The plugin's own stays switched off: it takes explicit steps, and its Coriolis "
        "forces know the diagonal alone and, by its source, push the wrong way.",
        "Before gz-sim 8 an element <xUabsU> is called <xUU>, and <xDotU> counts positive.",
        *[f"Thrust lag of {axis}: {p.value:.4g} s; the Thruster plugin has none." for axis, p in vehicle.lags.items()],
    ]
    elements = [
        f"<!-- into <link name={quoteattr(link)}> -->",
        *_inertial(body, ["  <fluid_added_mass>", *water, "  </fluid_added_mass>"]),
        "<!-- into <model> -->",
        '<plugin filename="gz-sim-hydrodynamics-system" name="gz::sim::systems::Hydrodynamics">',
        f"  <link_name>{escape(link)}</link_name>",
        "  <disable_added_mass>true</disable_added_mass>",
        "  <disable_coriolis>true</disable_coriolis>",
        *own,
        *terms,
        "</plugin>",
    ]
    return fragment(remarks, elements), remarks


def uuv(vehicle: Vehicle, body: RigidBody, link: str, flu: bool) -> tuple[str, list[str]]:
    """The model `fossen` of UUV Simulator with all 36 entries of each matrix it reads; and the remarks."""
    sign = TURNED if flu else np.ones(6)
    linear, forward, quadratic = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros(6)
    for term, p in vehicle.terms.items():
        value = -p.value * _flips(term, sign)
        match _uuv_place(term):
            case "linear", column:
                linear[term.row, column] += value
            case "forward", column:
                forward[term.row, column] += value
            case "quadratic", _:
                quadratic[term.row] += value
    remarks = [
        *vehicle_remarks(vehicle, body, lambda term: _uuv_place(term) is not None, flu),
        "<linear_damping_forward_speed> is what grows with the surge velocity u: a force per u times a velocity.",
        *[
            f"Thrust lag of {axis}: into the plugin of each of its thrusters <dynamics><type>FirstOrder</type>"
            f"<timeConstant>{p.value:.6g}</timeConstant></dynamics>."
            for axis, p in vehicle.lags.items()
        ],
    ]
    elements = [
        f"<link name={quoteattr(link)}>",
        *(f"  {line}" for line in _urdf_inertial(body)),
        "  <hydrodynamic_model>",
        "    <type>fossen</type>",
        f"    <added_mass>{_list(body.added * np.outer(sign, sign))}</added_mass>",
        f"    <linear_damping>{_list(linear)}</linear_damping>",
        f"    <linear_damping_forward_speed>{_list(forward)}</linear_damping_forward_speed>",
        f"    <quadratic_damping>{_list(quadratic)}</quadratic_damping>",
        "  </hydrodynamic_model>",
        "</link>",
    ]
    return fragment(remarks, elements), remarks


def stonefish(vehicle: Vehicle, body: RigidBody, flu: bool) -> tuple[str, list[str]]:
    """The elements of Stonefish: mass, moments of inertia, centre of gravity and the rotors' lag; and the remarks."""
    righting = [p.value for term, p in vehicle.terms.items() if term.kind == RIGHTING]
    remarks = [
        *vehicle_remarks(vehicle, body, lambda term: term.kind == RIGHTING, flu),
        "Stonefish makes drag and added mass of the body's shape and has no place for identified ones. "
        '<hydrodynamics viscous_drag="0 0 0" quadratic_drag="0 0 0"/> takes the drag of the shape away; apply the '
        "coefficients as a force of your own.",
        'With physics="floating" Stonefish adds no mass by the shape: the moments of inertia below include the water, '
        "and <mass> is the body's alone, for there is one for three directions.",
    ]
    elements = []
    if body.mass is not None:
        elements.append(f'<mass value="{_n(body.mass)}"/>')
    if body.inertia is not None:
        whole = body.inertia + np.diag(body.added)[3:]
        elements.append(f'<inertia xyz="{_list(whole)}"/>')
    if righting and body.mass is not None:
        depth = float(np.mean(righting)) / (body.mass * STANDARD_GRAVITY)
        elements.append(f'<cg xyz="0 0 {_n(depth)}" rpy="0 0 0"/>')
    for axis, p in vehicle.lags.items():
        elements += [
            f"<!-- into the <actuator> of each thruster of {axis} -->",
            '<rotor_dynamics type="first_order">',
            f'  <time_constant value="{_n(p.value)}"/>',
            "</rotor_dynamics>",
        ]
    return fragment(remarks, elements), remarks


def _gazebo_name(term: Term) -> str | None:
    """The element of the plugin that holds a term; None where none does."""
    force, own = FORCES[term.row], SPEEDS[term.row]
    of = [SPEEDS[VELOCITIES.index(name)] for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear":
            return force + own
        case "quadratic":
            return f"{force}{own}abs{own}"
        case "cross":
            return force + of[0]
        case "cross_size":
            return f"{force}{of[1]}abs{of[0]}"
        case "product":
            return force + of[0] + of[1]
        case "square":
            return force + 2 * of[0]
        case _:
            return None


def _uuv_place(term: Term) -> tuple[str, int] | None:
    """Matrix and column that hold a term; None where none does."""
    of = [VELOCITIES.index(name) for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear" | "quadratic":
            return term.kind, term.row
        case "cross":
            return "linear", of[0]
        case "product" if 0 in of:
            return "forward", of[0] + of[1]
        case "square" if of == [0]:
            return "forward", 0
        case _:
            return None


def _flips(term: Term, sign: Array) -> float:
    """The sign of a term's coefficient in other axes: that of its force, and of each velocity whose sign counts."""
    of = [VELOCITIES.index(name) for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear" | "quadratic":
            of = [term.row]
        case "cross_size":
            of = of[1:]
        case "square":
            of = []
    return float(sign[term.row] * np.prod(sign[of]))


def _inertial(body: RigidBody, water: Sequence[str]) -> list[str]:
    """SDFormat's <inertial>."""
    lines = [] if body.mass is None else [f"  <mass>{_n(body.mass)}</mass>"]
    if body.inertia is not None:
        moments = zip(("ixx", "iyy", "izz"), body.inertia.tolist(), strict=True)
        lines += ["  <inertia>", *(f"    <{name}>{_n(value)}</{name}>" for name, value in moments), "  </inertia>"]
    return ["<inertial>", *lines, *water, "</inertial>"]


def _urdf_inertial(body: RigidBody) -> list[str]:
    """URDF's <inertial>."""
    lines = [] if body.mass is None else [f'  <mass value="{_n(body.mass)}"/>']
    if body.inertia is not None:
        x, y, z = (_n(value) for value in body.inertia.tolist())
        lines.append(f'  <inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/>')
    return ["<inertial>", *lines, "</inertial>"] if lines else []


def _n(value: float) -> str:
    return f"{value:.9g}"


def _list(values: Array) -> str:
    return " ".join(_n(value) for value in values.ravel().tolist())
