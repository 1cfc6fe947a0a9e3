"""The words of an axis: what its quantities, their units and the vehicle's motion along it are called in sentences.

Where a sentence is made it names them by these fields, so that it is right of every axis from the start. A constant
text is a template of the same fields in braces, which `AxisWords.fill` fills.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cache

from incsvr.plant.axes import YAW, Axis


@dataclass(frozen=True, slots=True)
class AxisWords:
    """The words of sentences about one axis; the examples are yaw's and surge's.

    Attributes:
        name, title: of the axis: yaw, surge; Yaw, Surge.
        rate, rates, rate_title: its velocity: yaw rate, surge velocity; yaw rates; Yaw rate.
        rate_column, effort_column: their columns in a recording: yaw_rate, torque; surge, surge_force.
        effort, effort_title: what the actuators apply: torque, force.
        moment: what else acts: moment, force.
        inertia: inertia, mass.
        moment_of_inertia, inertia_with_added_mass: the same in full: moment of inertia; mass, with its added mass.
        turns, drives, draws: what the vehicle does, and what is done to it: turns, moves; turns, pushes; turns, pulls.
        sense: sense of turning, direction of motion.
        symbol, force_symbol, inertia_symbol, added_mass: SNAME's letters: r, N, I, I_z − N_ṙ.
        linear, quadratic: its letters of the damping: N_r, N_r|r|.
        rate_unit, effort_unit, inertia_unit, linear_unit, quadratic_unit, stiffness_unit, kernel_unit: of SI.
        other_unit: what a velocity that is too fast may be in.
    """

    name: str
    title: str
    rate: str
    rates: str
    rate_title: str
    rate_column: str
    effort_column: str
    symbol: str
    force_symbol: str
    inertia_symbol: str
    added_mass: str
    linear: str
    quadratic: str
    effort: str = "torque"
    effort_title: str = "Torque"
    moment: str = "moment"
    inertia: str = "inertia"
    moment_of_inertia: str = "moment of inertia"
    inertia_with_added_mass: str = "moment of inertia with its added mass"
    turns: str = "turns"
    drives: str = "turns"
    draws: str = "turns"
    sense: str = "sense of turning"
    rate_unit: str = "rad/s"
    effort_unit: str = "N m"
    inertia_unit: str = "kg m²"
    linear_unit: str = "N m s/rad"
    quadratic_unit: str = "N m s²/rad²"
    stiffness_unit: str = "N m/rad"
    kernel_unit: str = "s²/rad²"
    other_unit: str = "degrees per second"

    def stream(self, name: str) -> str:
        """The words for one of the two streams `yaw_rate` and `torque`, which are any axis's here."""
        return self.rate if name == YAW.rate else self.effort

    def fill(self, template: str) -> str:
        """The template with these words in the place of their names in braces."""
        return template.format_map(asdict(self))


_TRANSLATION = {
    "effort": "force",
    "effort_title": "Force",
    "moment": "force",
    "inertia": "mass",
    "moment_of_inertia": "mass, with its added mass",
    "inertia_with_added_mass": "mass, with its added mass",
    "turns": "moves",
    "drives": "pushes",
    "draws": "pulls",
    "sense": "direction of motion",
    "rate_unit": "m/s",
    "effort_unit": "N",
    "inertia_unit": "kg",
    "linear_unit": "N s/m",
    "quadratic_unit": "N s²/m²",
    "stiffness_unit": "N/m",
    "kernel_unit": "s²/m²",
    "other_unit": "other units",
}
"""The words that differ between axes of translation and of rotation."""
_ADDED_MASS = {
    "surge": "m − X_u̇",
    "sway": "m − Y_v̇",
    "heave": "m − Z_ẇ",
    "roll": "I − K_ṗ",
    "pitch": "I − M_q̇",
    "yaw": "I_z − N_ṙ",
}
"""SNAME's inertia with added mass."""


@cache
def words_of(axis: Axis) -> AxisWords:
    """The words of an axis."""
    velocity, linear = "velocity" if axis.along else "rate", f"{axis.force_symbol}_{axis.symbol}"
    return AxisWords(
        name=axis.name,
        title=axis.name.capitalize(),
        rate=f"{axis.name} {velocity}",
        rates=f"{axis.name} {'velocities' if axis.along else 'rates'}",
        rate_title=f"{axis.name.capitalize()} {velocity}",
        rate_column=axis.rate,
        effort_column=axis.effort,
        symbol=axis.symbol,
        force_symbol=axis.force_symbol,
        inertia_symbol="m" if axis.along else "I",
        added_mass=_ADDED_MASS[axis.name],
        linear=linear,
        quadratic=f"{linear}|{axis.symbol}|",
        **(_TRANSLATION if axis.along else {}),
    )


YAW_WORDS = words_of(YAW)
"""The words of the paper's axis."""
