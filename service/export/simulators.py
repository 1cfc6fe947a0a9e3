"""A vehicle as elements of Gazebo and of Stonefish. What an element cannot hold stands in a comment before it.

Signs and names were read in each tool's documentation and source: gz-sim, systems/hydrodynamics/Hydrodynamics.hh, .cc
and HydrodynamicsUtils.hh; SDFormat, inertial.sdf; Stonefish, docs/bodies.rst and docs/actuators.rst. Both count
hydrodynamic derivatives, negative where they oppose the motion. Stonefish counts ahead, to starboard and down, as SNAME
does; Gazebo ahead, to port and up.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES
from incsvr.plant.terms import RIGHTING, Term
from incsvr.vehicle import Vehicle
from service.export.remarks import STANDARD_GRAVITY, vehicle_remarks
from service.export.rigid_body import RigidBody
from service.export.template import filled

FORCES, SPEEDS, MASSES = "xyzkmn", "UVWPQR", "xyzpqr"
"""Letters of SNAME in the elements of Gazebo's plugin, and those of an added mass in SDFormat."""
TURNED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""The signs of ν between axes to starboard and down, and axes to port and up."""


def gazebo(vehicle: Vehicle, body: RigidBody, flu: bool) -> tuple[str, list[str]]:
    """The link's <inertial> with its <fluid_added_mass>, and the Hydrodynamics plugin of gz-sim; and the remarks.

    Args:
        flu: whether the vehicle file counts to port and up already.
    """
    sign = np.ones(6) if flu else TURNED
    added = body.added * np.outer(sign, sign)
    places = [(int(a), int(b)) for a, b in np.argwhere(np.triu(added))]
    remarks = [
        *vehicle_remarks(vehicle, body, lambda term: _gazebo_name(term) is not None, flu),
        "Axes are Gazebo's: ahead, to port, up. The link is called base_link here.",
        "The added mass is in <fluid_added_mass> (SDFormat 1.10, gz-sim 8, the physics engine DART), with the Coriolis "
        "forces that follow from it. The plugin's own stays switched off: it takes explicit steps, and its Coriolis "
        "forces know the diagonal alone and, by its source, push the wrong way.",
        "Before gz-sim 8 an element <xUabsU> is called <xUU>.",
        *[f"Thrust lag of {axis}: {p.value:.4g} s; the Thruster plugin has none." for axis, p in vehicle.lags.items()],
    ]
    moments = [] if body.inertia is None else zip(("ixx", "iyy", "izz"), body.inertia.tolist(), strict=True)
    inertia = _lines((name, value) for name, value in moments)
    text = filled(
        "gazebo",
        remarks=_comment(remarks),
        body=([] if body.mass is None else _lines([("mass", body.mass)]))
        + (["  <inertia>", *(f"  {line}" for line in inertia), "  </inertia>"] if inertia else []),
        water=[f"  {each}" for each in _lines((MASSES[a] + MASSES[b], added[a, b]) for a, b in places)],
        terms=_lines(
            (name, -p.value * _flips(term, sign))
            for term, p in vehicle.terms.items()
            if (name := _gazebo_name(term)) is not None
        ),
    )
    return text, remarks


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
    elements = [] if body.mass is None else [f'<mass value="{body.mass:.9g}"/>']
    if body.inertia is not None:
        whole = body.inertia + np.diag(body.added)[3:]
        elements.append(f'<inertia xyz="{" ".join(f"{value:.9g}" for value in whole.tolist())}"/>')
    if righting and body.mass is not None:
        depth = float(np.mean(righting)) / (body.mass * STANDARD_GRAVITY)
        elements.append(f'<cg xyz="0 0 {depth:.9g}" rpy="0 0 0"/>')
    rotors = [
        f'<!-- into the <actuator> of each thruster of {axis} -->\n<rotor_dynamics type="first_order">\n'
        f'  <time_constant value="{p.value:.9g}"/>\n</rotor_dynamics>'
        for axis, p in vehicle.lags.items()
    ]
    return filled("stonefish", remarks=_comment(remarks), body=elements, rotors=rotors), remarks


def _lines(elements: Iterable[tuple[str, float]]) -> list[str]:
    """Elements with a number each."""
    return [f"  <{name}>{value:.9g}</{name}>" for name, value in elements]


def _comment(remarks: Sequence[str]) -> list[str]:
    """Lines of a comment, in which two hyphens may not stand, so that others take their place."""
    return ["     " + line.replace("--", "\u2010\u2010") for line in remarks]


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
