"""The terms of a vehicle file as rows of the engine, both ways, and the stages of its thrust."""

from __future__ import annotations

from incsvr.model.efforts import Stage
from incsvr.model.rows import ONE, Factor, Part, Row, size, value
from incsvr.plant.axes import AXES, VELOCITIES, of_rate
from incsvr.plant.terms import AXES_BY_RATE, Term, term

DOWN = {"surge": "down_x", "sway": "down_y", "heave": "down_z", "roll": "down_y", "pitch": "down_x"}
"""The part of the downward direction that acts along an axis, or rights the vehicle about it."""
STAGES = {
    "dead": "dead_zone", "limit": "limit", "exponent": "exponent", "reverse": "reverse", "spin": "rotor_lag_s",
    "shift": "delay_s",
}  # fmt: skip
"""Stages of an effort in a vehicle file, by their names in the engine."""
FULL = "full_effort"
"""The effort at which a thrust curve with an exponent gives what is demanded; it is in the file beside the exponent."""
CALLED = {
    "bias_torque": "bias", "coupling": "cross", "coriolis": "product", "cross_flow": "cross_size",
    "thrust_speed": "inflow", "inflow": "advance",
}  # fmt: skip
"""Kinds of rows that a vehicle file calls otherwise."""
LEFT = ("memory", "gyro_bias", "gap", "sag")
"""Effects that a vehicle file has no term for; of a dead band and a limit it has one shape each."""


def row_of(term: Term) -> Row:
    """The engine's row of a term, whose coefficient is the term's."""
    axis = AXES[term.axis]
    rate, effort = value(axis.rate), value(axis.effort)
    of = term.of

    def row(one: Factor, other: Factor = ONE, sign: float = 1.0) -> Row:
        return Row(term.name, (Part(axis.rate, one, other, sign),))

    match term.kind:
        case "linear":
            return row(rate)
        case "quadratic":
            return row(size(axis.rate), rate)
        case "cross":
            return row(value(of[0]))
        case "cross_size":
            return row(size(of[0]), value(of[1]) if of[1:] else ONE)
        case "product" | "square":
            return row(value(of[0]), value(of[-1]))
        case "effort":
            return row(value(AXES[of[0]].effort), sign=-1.0)
        case "inflow":
            return row(size(of[0]), effort)
        case "advance":
            return row(rate, Factor("root", axis.effort))
        case "reverse":  # min(τ, 0) is half of τ less |τ|
            both = ((effort, 0.5), (size(axis.effort), -0.5))
            return Row(term.name, tuple(Part(axis.rate, one, ONE, sign) for one, sign in both))
        case "weight" | "righting":
            return row(Factor(DOWN[term.axis]), sign=1.0 if term.axis == "roll" else -1.0)
        case "coulomb" | "coulomb_asymmetry":
            sign = Factor("sign", axis.rate, float(of[0]))
            return row(sign, ONE if term.kind == "coulomb" else sign)
        case "bend":
            return row(Factor("bend", axis.rate, float(of[0])))
        case _:
            return row(ONE)


def terms_of(row: Row) -> list[tuple[Term, float]]:
    """The terms of a row of the engine, one an axis, each with the sign of its coefficient."""
    kind, _, of = row.name.partition(":")
    found = []
    for part in row.parts:
        axis = of_rate(part.axis).name
        if row.name == "bend:uneven":
            found.append((Term(axis, "square", (part.axis,)), 1.0))
        elif row.name == "bend:uneven linear":
            found.append((Term(axis, "cross_size", (part.axis,)), 1.0))
        elif kind in ("coulomb", "coulomb_asymmetry", "bend"):
            found.append((Term(axis, kind, (f"{part.one.width:.4g}",)), 1.0))
        elif kind == "effort":
            found.append((Term(axis, kind, (of_rate(of).name,)), -1.0))
        elif of.startswith("|"):  # coupling:|sway|sway
            found.append((Term(axis, "cross_size", (of.rpartition("|")[2],) * 2), 1.0))
        else:
            named = f"{of}*{part.axis}" if kind == "cross_flow" else of
            named = "*".join(sorted(named.split("*"), key=VELOCITIES.index)) if kind == "coriolis" else named
            found.append((term(axis, f"{CALLED.get(kind, kind)}:{named}".rstrip(":")), 1.0))
    return found


def static_stage(thrust: dict[str, float]) -> tuple[Stage, float]:
    """The stages that act on the samples of an effort, and the effort at which its curve gives what is demanded."""
    exponent, dead, limit, reverse = (thrust.get(STAGES[own]) for own in ("exponent", "dead", "limit", "reverse"))
    return Stage(exponent=exponent, dead=dead, limit=limit, reverse=reverse), thrust.get(FULL, 1.0)


def rates(axes: tuple[str, ...]) -> tuple[str, ...]:
    """The velocities of axes by their names."""
    return tuple(AXES[axis].rate for axis in axes)


def pair_of(name: str) -> tuple[str, str]:
    """Both axes of an entry of M by its name in the engine, as `mass:sway*yaw_rate`."""
    one, _, other = name.removeprefix("mass:").partition("*")
    return AXES_BY_RATE[one].name, AXES_BY_RATE[other or one].name
