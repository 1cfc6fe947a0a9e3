"""Elements of simulators' own files; a comment before an element names what it cannot contain.

Signs and names were read in each tool's documentation and source: gz-sim, systems/hydrodynamics/Hydrodynamics.hh and
.cc (since its pull request 1888); UUV Simulator, uuv_gazebo_plugins/src/HydrodynamicModel.cc (HMFossen) and
urdf/thruster_snippets.xacro; Stonefish, docs/actuators.rst and docs/bodies.rst. All of them count N_r and N_{r|r|} as
hydrodynamic derivatives, negative where damping opposes.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape

from incsvr.errors import BadInput
from service.export.damping_model import DampingModel
from service.export.fragment import fragment

YAW = 5
"""The place of yaw among surge, sway, heave, roll, pitch and yaw."""


def gazebo(model: DampingModel, link: str, dry: float | None) -> str:
    """The Hydrodynamics plugin of gz-sim: <nR>, <nRabsR>, and <nDotR> where the dry inertia is known."""
    said = [
        "Axes that are not named here are 0 for this plugin: put the elements into the one that the vehicle has.",
        "Before gz-sim 8 <nRabsR> is called <nRR>, and <nDotR> counts positive.",
    ]
    if dry is None:
        said.append(
            f"<izz> of the link takes all of I = {model.inertia.estimate:.6g} kg m^2, and <nDotR> stays away; to "
            "part body and water, export with --dry-inertia"
        )
        added = []
    else:
        water = _added(model, dry)
        said.append(
            f"<izz> of the link is the dry {dry:.6g} kg m^2. Where the added inertia is large beside it, the plugin's "
            f"explicit step may swing: take <nDotR> away then, set <disable_added_mass>, and give the link's "
            f"<inertial> <fluid_added_mass><rr>{water:.6g}</rr></fluid_added_mass>"
        )
        added = [f"  <nDotR>{-water:.6g}</nDotR>"]
    said += _thrust(model, "The Thruster plugin holds")
    return fragment(
        [*model.remark(), *said],
        [
            '<plugin filename="gz-sim-hydrodynamics-system" name="gz::sim::systems::Hydrodynamics">',
            f"  <link_name>{escape(link)}</link_name>",
            f"  <nR>{-model.linear.estimate:.6g}</nR>",
            f"  <nRabsR>{-model.quadratic.estimate:.6g}</nRabsR>",
            *added,
            "</plugin>",
        ],
    )


def uuv(model: DampingModel, link: str, dry: float | None) -> str:
    """The model `fossen` of UUV Simulator: 36 elements of added mass, positive, and six of each damping."""
    water = 0.0 if dry is None else _added(model, dry)
    mass = [water if row == column == YAW else 0.0 for row in range(6) for column in range(6)]
    said = ["Axes that were not learned are 0: put their own in their places."]
    if dry is None:
        said.append(
            f"<izz> of the link takes all of I = {model.inertia.estimate:.6g} kg m^2, and yaw's added mass is 0; to "
            "part body and water, export with --dry-inertia"
        )
    lag = model.of("torque_lag", "time_constant_s")
    if lag is not None:
        said.append(
            "Into each yaw thruster's plugin: <dynamics><type>FirstOrder</type><timeConstant>"
            f"{lag.estimate:.6g}</timeConstant></dynamics>"
        )
    said += _thrust(model, "The thruster's plugin holds", held=("torque_lag",))
    return fragment(
        [*model.remark(), *said],
        [
            f'<link name="{escape(link, {chr(34): "&quot;"})}">',
            "  <hydrodynamic_model>",
            "    <type>fossen</type>",
            f"    <added_mass>{_list(mass)}</added_mass>",
            f"    <linear_damping>{_list(_yaw(-model.linear.estimate))}</linear_damping>",
            f"    <quadratic_damping>{_list(_yaw(-model.quadratic.estimate))}</quadratic_damping>",
            "  </hydrodynamic_model>",
            "</link>",
        ],
    )


def stonefish(model: DampingModel, across: tuple[float, float] | None) -> str:
    """The elements of Stonefish: the body's inertia and the rotor's lag. It has no place for N_r: its drag comes of
    the body's shape, with two numbers for each axis of translation.

    Raises:
        BadInput: there is nothing that it could hold.
    """
    lag = model.of("torque_lag", "time_constant_s")
    if across is None and lag is None:
        raise BadInput(
            "Stonefish makes its drag of the body's shape and has no place for N_r; of what was learned it holds the "
            "inertia, with --inertia-xy IX IY beside it, and a thrust lag, which was not traced; export as json, and "
            "apply the damping as a moment of your own"
        )
    said = [
        "Stonefish makes its drag of the body's shape: it has no place for N_r and N_r|r|. Apply them as a moment of "
        'your own; <hydrodynamics viscous_drag="0 0 0" quadratic_drag="0 0 0"/> takes the shape\'s own drag away, on '
        "all axes."
    ]
    elements = []
    if across is not None:
        said.append(
            'The inertia holds the water about yaw: give the link physics="floating", which adds none, not "submerged".'
        )
        values = " ".join(f"{value:.6g}" for value in (*across, model.inertia.estimate))
        elements.append(f'<inertia xyz="{values}"/>')
    if lag is not None:
        said.append("The rotor's dynamics go into each yaw thruster's <actuator>.")
        elements += [
            '<rotor_dynamics type="first_order">',
            f'  <time_constant value="{lag.estimate:.6g}"/>',
            "</rotor_dynamics>",
        ]
    said += _thrust(model, "<thrust_model> counts in a propeller's speed and holds", held=("torque_lag",))
    return fragment([*model.remark(), *said], elements)


def _added(model: DampingModel, dry: float) -> float:
    """The water's part of the inertia [kg m²]."""
    if not 0.0 < dry < model.inertia.estimate:
        raise BadInput(
            f"--dry-inertia {dry:g}: the body alone must have less than the {model.inertia.estimate:.6g} kg m² of "
            "body and water together, and more than 0"
        )
    return model.inertia.estimate - dry


def _thrust(model: DampingModel, holder: str, held: Sequence[str] = ()) -> list[str]:
    """A line on the effects of the thrust that no element holds."""
    rest = [effect.name for effect in model.effects if effect.name not in (*held, "inertia", "drag_drift", "drag_step")]
    return [f"{holder} nothing of: {', '.join(rest)}."] if rest else []


def _yaw(value: float) -> list[float]:
    return [value if axis == YAW else 0.0 for axis in range(6)]


def _list(values: Sequence[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)
