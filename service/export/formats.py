"""A vehicle as text: a table (csv), a world of Gazebo, elements of Stonefish, and a Python file that simulates.

What an element cannot hold is in a comment before it. Signs and names were read in each tool's documentation and
source: gz-sim, systems/hydrodynamics/Hydrodynamics.hh, .cc and HydrodynamicsUtils.hh, systems/buoyancy/Buoyancy.cc;
gz-physics, dartsim/src/SimulationFeatures.cc; SDFormat, sdf/1.10; Stonefish, docs/bodies.rst and docs/actuators.rst.
Both count hydrodynamic derivatives, negative where they oppose the motion. Stonefish counts ahead, to starboard and
down, as SNAME does; Gazebo ahead, to port and up.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from string import Template

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import Interval
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.terms import RIGHTING, WEIGHT, Term, stage_unit, thrust_name
from incsvr.vehicle import Vehicle
from incsvr.vehicle.equation import STAGES
from incsvr.vehicle.model import ASSUMED, BOUND_REACHED, STEPS_A_DECAY, UNKNOWN
from service.fitting.parameters import parameters

ALONG, ABOUT = slice(0, 3), slice(3, 6)
"""Places of the translations and of the rotations in ν."""
HEADER = ("quantity", "estimate", "low", "high", "unit")
MASSES = "xyzpqr"
"""Letters of an added mass in SDFormat, in the order of ν."""
TURNED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""The signs of ν between axes to starboard and down, and axes to port and up."""
STANDARD_GRAVITY = 9.80665
"""[m/s²]."""
WATER = 1000.0
"""Density [kg/m³] of the water of a simulated world. The hull's volume follows from it, and the motion does not."""
HULL = np.array([2.0, 1.5, 1.0])
"""Sides of the box that stands for a hull, one to another: its bow is told from its side."""


@dataclass(frozen=True, slots=True)
class RigidBody:
    """A rigid body whose centre of mass is at the origin, and the rest of M.

    Attributes:
        mass: m [kg]; None where no translation was identified.
        inertia: (3,) moments about roll, pitch and yaw [kg m²]; None where no rotation was identified.
        added: (6, 6) M less that body; zero in the rows of axes that were not identified.
        declared: whether somebody gave the mass and the moments of what was identified.
        guessed: whether moments stand for axes that nobody identified or gave.
    """

    mass: float | None
    inertia: Array | None
    added: Array
    declared: bool
    guessed: bool


def parted(
    vehicle: Vehicle,
    mass: float | None = None,
    about_yaw: float | None = None,
    across: tuple[float, float] | None = None,
) -> RigidBody:
    """M in two parts. A log shows only their sum, which moves the vehicle; the body's own mass decides its weight.

    Args:
        mass: of the body alone [kg]; None takes what the identified axes admit at most.
        about_yaw, across: moments of the body alone about yaw, and about roll and pitch [kg m²]; None likewise, the
            same about all three, and all of it about yaw where `across` is given.

    Raises:
        BadInput: what is given is no inertia, or more than that of body and water together.
    """
    for value in (mass, about_yaw, *(across or ())):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise BadInput(f"{value:g} is no moment of inertia; give a positive number in kg m² (a mass in kg)")
    if (about_yaw is None) != (across is None) and {"roll", "pitch"} & set(vehicle.axes):
        raise BadInput("the body's moments of inertia need --dry-inertia and --inertia-xy together, for this vehicle")
    rows = vehicle.rows
    total = np.zeros((6, 6))
    total[np.ix_(rows, rows)] = vehicle.mass_matrix[np.ix_(rows, rows)]
    diagonal = np.diag(total)
    along, about = diagonal[ALONG][diagonal[ALONG] > 0.0], diagonal[ABOUT][diagonal[ABOUT] > 0.0]
    body = np.zeros(6)
    body[ALONG] = along.min(initial=np.inf) if mass is None else mass
    usual = about.min(initial=np.inf) if about_yaw is None else about_yaw
    body[ABOUT] = (*((usual, usual) if across is None else across), usual)
    given = about_yaw is not None or across is not None
    if mass is None and not given:
        # The largest part of such a body that leaves an added mass without negative energies.
        scale = 1.0 / np.sqrt(body[rows])
        body *= min(1.0, float(np.linalg.eigvalsh(total[np.ix_(rows, rows)] * np.outer(scale, scale))[0]))
    added = total.copy()
    added[rows, rows] -= body[rows]
    for row in rows:
        if added[row, row] < -1e-9 * total[row, row]:
            raise BadInput(
                f"the body alone has {body[row]:g} along {list(AXES)[row]}, and body and water together "
                f"{total[row, row]:.6g}; give less with --dry-mass, --dry-inertia and --inertia-xy"
            )
    if given and 2.0 * body[ABOUT].max() > (1.0 + 1e-9) * body[ABOUT].sum():
        raise BadInput(
            f"no body has the moments {', '.join(f'{each:g}' for each in body[ABOUT])}: one is more than the others "
            "together; mend --dry-inertia and --inertia-xy"
        )
    added[np.abs(added) < 1e-12 * diagonal.max()] = 0.0  # what rounding leaves of nothing
    turns = bool(np.isfinite(body[ABOUT]).all())
    return RigidBody(
        float(body[0]) if np.isfinite(body[0]) else None,
        body[ABOUT] if turns else None,
        added,
        (mass is not None or not along.size) and (given or not about.size),
        turns and across is None and about.size < 3,
    )


def table(figures: Iterable[tuple[str, Interval, str]]) -> str:
    """One figure a row as CSV, with its interval and unit."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    for name, p, unit in figures:
        ends = ("" if math.isnan(end) else repr(end) for end in (p.low, p.high))
        writer.writerow([name, repr(p.estimate), *ends, unit])
    return out.getvalue()


def vehicle_figures(vehicle: Vehicle) -> Iterator[tuple[str, Interval, str]]:
    """The figures of a vehicle by name, with their units; damping counts positive where it opposes."""
    for pair, name, unit, p in parameters(vehicle):
        yield f"{'-'.join(dict.fromkeys(pair))} {name}", Interval(p.value, p.low, p.high), unit


def python_module(vehicle: Vehicle, casadi: bool = False) -> str:
    """A Python file that simulates as `incsvr` does, with NumPy alone, or with CasADi too."""
    names = list(AXES)

    def expression(term: Term) -> str:
        return _expression(term).replace("np.", "m.") if casadi else _expression(term)

    return _filled(
        "casadi" if casadi else "python",
        name=vehicle.name.replace("\\", "\\\\").replace('"', '\\"'),
        doubts=[f"# {each}" for each in doubts(vehicle)],
        axes=repr(names),
        rows=vehicle.rows,
        mass=vehicle.mass_matrix.tolist(),
        lags={names.index(axis): p.value for axis, p in vehicle.all_lags.items()},
        rotors=[names.index(axis) for axis in vehicle.rotor_lags],
        fastest=vehicle.fastest.tolist(),
        decay=vehicle.decay,
        steps_a_decay=STEPS_A_DECAY,
        terms=[
            f"    f[{term.row}] += {p.value!r} * {expression(term)}  # {term.name} [{term.unit}]"
            for term, p in vehicle.terms.items()
        ],
        delays={names.index(axis): of["delay_s"].value for axis, of in vehicle.thrust.items() if "delay_s" in of},
        thrust={
            names.index(axis): {name: p.value for name, p in of.items() if name != STAGES["spin"]}
            for axis, of in vehicle.thrust.items()
        },
    )


def gazebo(vehicle: Vehicle, body: RigidBody, flu: bool) -> tuple[str, list[str]]:
    """A world of gz-sim in SDFormat with the vehicle in water, and the remarks.

    Args:
        flu: whether the vehicle file counts to port and up already.

    Raises:
        BadInput: the body weighs less than what it sinks with.
    """
    sign = np.ones(6) if flu else TURNED
    added = body.added * np.outer(sign, sign)
    elements = {
        term: (_letters(term), -p.value * sign[term.row] * float(np.prod(sign[_factors(term)[0]])))
        for term, p in vehicle.terms.items()
        if any(_factors(term))
    }
    mass, moments, guess = _whole(body)
    lift, height = _afloat(vehicle, mass, flu)
    if lift <= 0.0:
        raise BadInput(f"the vehicle's weight in water is more than that of {mass:.4g} kg; give more as --dry-mass")
    name = re.sub(r"\W+", "_", vehicle.name, flags=re.ASCII).strip("_")
    name = name if name not in ("", "world") else "vehicle"  # SDFormat keeps "world" for itself
    remarks = [
        *_remarks(vehicle, replace(body, mass=mass), elements, flu),
        *([guess] if guess else []),
        "Axes are Gazebo's: ahead, to port, up. The link is called base_link here.",
        "The box is not the hull: its volume carries the weight less the part that sinks. The water has no surface.",
        f"Thrusters are yours to add. /world/{name}/wrench/persistent takes force and torque, along the world's axes.",
        "The added mass is in <fluid_added_mass> (SDFormat 1.10, gz-sim 8, the physics engine DART), with the Coriolis "
        "forces that follow from it. The plugin's own stays switched off: it takes explicit steps, and its Coriolis "
        "forces know the diagonal alone and, by its source, push the wrong way.",
        *[
            f"Thrust lag of {axis}: {p.value:.4g} s; the Thruster plugin has none."
            for axis, p in vehicle.all_lags.items()
        ],
    ]
    places = [(int(a), int(b)) for a, b in np.argwhere(np.triu(added))]
    sides = HULL * (lift / (STANDARD_GRAVITY * WATER * HULL.prod())) ** (1.0 / 3.0)
    text = _filled(
        "gazebo",
        remarks=_comment(remarks),
        name=name,
        gravity=STANDARD_GRAVITY,
        density=f"{WATER:g}",
        mass=f"{mass:.9g}",
        height=f"{height:.9g}",
        sides=" ".join(f"{side:.9g}" for side in sides),
        water=_lines(((MASSES[a] + MASSES[b], added[a, b]) for a, b in places), 12),
        terms=_lines(elements.values(), 8),
        **{name: f"{each:.9g}" for name, each in zip(("ixx", "iyy", "izz"), moments, strict=True)},
    )
    return text, remarks


def stonefish(vehicle: Vehicle, body: RigidBody, flu: bool) -> tuple[str, list[str]]:
    """The elements of Stonefish: mass, moments of inertia, centre of gravity and the rotors' lag; and the remarks."""
    righting = {term: p.value for term, p in vehicle.terms.items() if term.kind == RIGHTING}
    remarks = [
        *_remarks(vehicle, body, righting, flu),
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
        elements.append(f'<cg xyz="0 0 {_afloat(vehicle, body.mass, flu)[1]:.9g}" rpy="0 0 0"/>')
    rotors = [
        f'<!-- into the <actuator> of each thruster of {axis} -->\n<rotor_dynamics type="first_order">\n'
        f'  <time_constant value="{p.value:.9g}"/>\n</rotor_dynamics>'
        for axis, p in vehicle.all_lags.items()
    ]
    return _filled("stonefish", remarks=_comment(remarks), body=elements, rotors=rotors), remarks


def doubts(vehicle: Vehicle) -> list[str]:
    """The parameters that the dives do not show, and what else is doubted, as sentences."""
    named = {f"{t.axis} {t.name}": p for t, p in vehicle.terms.items()}
    named |= {f"{a} inertia" if a == b else f"{a}-{b} inertia": p for (a, b), p in vehicle.mass.items()}
    unsure = [f"{name} ({p.origin})" for name, p in named.items() if p.origin in (UNKNOWN, BOUND_REACHED, ASSUMED)]
    found = [f"The dives do not show: {', '.join(unsure)}."] if unsure else []
    return [*found, *(f"Doubt: {each}." for each in vehicle.doubts)]


def _remarks(vehicle: Vehicle, body: RigidBody, held: Collection[Term], flu: bool) -> list[str]:
    """Sentences on elements that contain the terms `held`: their range, the guesses, and the parts left out."""
    fastest = ", ".join(
        f"{n} {v:.3g}" for n, v in zip(AXES, vehicle.fastest.tolist(), strict=True) if n in vehicle.axes
    )
    missing = [name for name in AXES if name not in vehicle.axes]
    lost = [
        f"{t.axis} {t.name} = {p.value:.4g} {t.unit}"
        for t, p in vehicle.terms.items()
        if t not in held and t.kind not in (RIGHTING, WEIGHT)
    ]
    lost += [
        f"{axis} {thrust_name(name)} = {p.value:.4g} {stage_unit(axis, name)}"
        for axis, of in vehicle.thrust.items() for name, p in of.items()
    ]  # fmt: skip
    found = [f"{vehicle.name}, identified by incsvr up to {fastest} (m/s, rad/s); beyond, it is a guess."]
    if missing:
        found.append(f"Not identified, and 0 here: added mass and damping of {', '.join(missing)}; put in your own.")
    found += doubts(vehicle)
    if lost:
        found.append(f"This format cannot hold: {'; '.join(lost)}.")
    part = "as declared" if body.declared else "the largest that body and water together admit"
    cure = "" if body.declared else "; --dry-mass, --dry-inertia and --inertia-xy declare it"
    found.append(
        f"The dives show only the sum of body and water. The body's part is {part}{cure}. The rest is added mass."
    )
    if body.guessed:
        found.append("The body's moments about the axes that are not identified are guesses.")
    for term, p in vehicle.terms.items():
        if term.kind == RIGHTING:
            lift = None if body.mass is None else _afloat(vehicle, body.mass, flu)[0]
            height = "" if lift is None else f", {p.value / lift:.4g} m for this mass"
            found.append(
                f"Righting moment of {term.axis}: {p.value:.4g} N m = buoyancy times the height of its centre above "
                f"the centre of mass{height}."
            )
        elif term.kind == WEIGHT and term.axis == "heave":  # its parts along the other axes have the same coefficient
            found.append(f"Weight less buoyancy: {-p.value if flu else p.value:.4g} N, which decides the volume.")
    return found


def _afloat(vehicle: Vehicle, mass: float, flu: bool) -> tuple[float, float]:
    """Buoyancy [N], and the height [m] of its centre above the centre of mass, of a body of that mass [kg]."""
    sinking = sum(p.value for t, p in vehicle.terms.items() if (t.kind, t.axis) == (WEIGHT, "heave"))
    lift = mass * STANDARD_GRAVITY - (-sinking if flu else sinking)
    righting = [p.value for term, p in vehicle.terms.items() if term.kind == RIGHTING]
    return lift, float(np.mean(righting)) / lift if righting else 0.0


def _whole(body: RigidBody) -> tuple[float, list[float], str]:
    """Mass [kg] and moments [kg m²]; a box of water lends what nothing identified shows, and a sentence says so."""
    squares = HULL**2
    a_kilogram = (squares.sum() - squares) / 12.0  # moments of the box for each kg, its height being 1 m
    of_height = WATER * HULL.prod()  # its mass, for each m³ of its height cubed
    if body.mass is None:
        assert body.inertia is not None, "a vehicle has an axis"
        mass = float(of_height * (body.inertia[2] / (of_height * a_kilogram[2])) ** 0.6)
        guess = "Nothing identified shows the mass; it is that of a box of water. --dry-mass declares it."
        return mass, body.inertia.tolist(), guess
    if body.inertia is None:
        moments = body.mass * (body.mass / of_height) ** (2.0 / 3.0) * a_kilogram
        return body.mass, moments.tolist(), "Nothing identified shows the moments of inertia; a box of water has these."
    return body.mass, body.inertia.tolist(), ""


def _factors(term: Term) -> tuple[list[int], list[int]]:
    """Places in ν of the velocities that a term multiplies, and of those whose size it multiplies; none for others."""
    of = [VELOCITIES.index(name) for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear":
            return [term.row], []
        case "quadratic":
            return [term.row], [term.row]
        case "cross" | "product":
            return of, []
        case "cross_size":
            return of[1:], of[:1]
        case "square":
            return of * 2, []
        case _:
            return [], []


def _letters(term: Term) -> str:
    """The element of Gazebo's plugin that holds a term of velocities."""
    letters = [axis.symbol.upper() for axis in AXES.values()]
    own, sizes = _factors(term)
    force = AXES[term.axis].force_symbol.lower()
    return force + "".join(letters[k] for k in own) + "".join(f"abs{letters[k]}" for k in sizes)


def _expression(term: Term) -> str:
    """φ in the names of the Python file."""
    own, sizes = _factors(term)
    if own:
        return " * ".join([*(f"u[{k}]" for k in own), *(f"abs(u[{k}])" for k in sizes)])
    match term.kind:
        case "effort":
            return f"-w[{list(AXES).index(term.of[0])}]"
        case "inflow":
            return f"w[{term.row}] * abs(u[{VELOCITIES.index(term.of[0])}])"
        case "reverse":
            return f"np.fmin(w[{term.row}], 0.0)"
        case "advance":
            return f"u[{term.row}] * np.sqrt(abs(w[{term.row}]))"
        case "coulomb" | "coulomb_asymmetry":
            return f"np.tanh(u[{term.row}] / {term.of[0]})" + " ** 2" * (term.kind == "coulomb_asymmetry")
        case "bend":
            return f"(u[{term.row}] - np.fmin(np.fmax(u[{term.row}], -{term.of[0]}), {term.of[0]}))"
        case "weight":
            down = {"surge": "-np.sin(pitch)", "sway": "np.cos(pitch) * np.sin(roll)"}
            return f"-({down.get(term.axis, 'np.cos(pitch) * np.cos(roll)')})"
        case "righting":
            return "np.cos(pitch) * np.sin(roll)" if term.axis == "roll" else "np.sin(pitch)"
        case _:
            return "1.0"


def _filled(template: str, /, **values: object) -> str:
    """The text of a template; a list of lines takes the place of a line, and an empty one takes it away."""
    lines = list[str]()
    for line in (files("service.export") / f"{template}.template").read_text(encoding="utf-8").splitlines():
        value = values.get(line.strip().removeprefix("$"))
        lines += map(str, value) if isinstance(value, list) else [Template(line).substitute(values)]
    return "\n".join(lines) + "\n"


def _lines(elements: Iterable[tuple[str, float]], indent: int) -> list[str]:
    """Elements with a number each."""
    return [f"{' ' * indent}<{name}>{value:.9g}</{name}>" for name, value in elements]


def _comment(remarks: Sequence[str]) -> list[str]:
    """Lines of a comment, in which two hyphens may not stand, so that others take their place."""
    return ["     " + line.replace("--", "\u2010\u2010") for line in remarks]
