"""The rows of the equation of motion: terms that oppose an axis's effort, as θ times a product of factors.

A row is data, so that a file can store it and an export can write it. Its name is the effect of CONTRACT, Section 5, or
the hull's term; with its axis it is unique: `cross_flow:surge@yaw_rate`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from incsvr.model.series import effort_of
from incsvr.plant.axes import AXES, LATERAL, VELOCITIES

INF = float("inf")


@dataclass(frozen=True, slots=True)
class Factor:
    """A function of one signal.

    Attributes:
        kind: one (1), value (x), size (|x|), square (x²), root (√|x|), sign (tanh(x / width)), sine, cosine, sine2 and
            cosine2 (of the double angle), wave and wave_later (sine and cosine of width times x), drag (x |x|), about
            (x − width), raised (|x| + width), bend (the part of x beyond ± width), after (0 before `width`, then 1),
            curve (by its table), or a part of the downward direction in the body's frame: down_x, down_y, down_z, from
            roll and pitch (Fossen 2011, Eq. 2.18).
        of: the signal's name: a velocity, an effort that acts, a channel, an angle, or a row's memory.
        width: of a sign, a mean, a cell of a table, or the instant of a step [unit of the signal]; the frequency of a
            wave [rad/s].
        table: of a curve: its values `width` apart, the middle one at zero.
    """

    kind: str
    of: str = ""
    width: float = 0.0
    table: tuple[float, ...] = ()


ONE = Factor("one")


def value(name: str) -> Factor:
    """x"""
    return Factor("value", name)


def size(name: str) -> Factor:
    """|x|"""
    return Factor("size", name)


@dataclass(frozen=True, slots=True)
class Part:
    """What a row contributes to one axis: θ times sign, times both factors.

    Attributes:
        axis: its velocity.
        one, other: the factors.
        sign: 1 or −1.
    """

    axis: str
    one: Factor
    other: Factor = ONE
    sign: float = 1.0


@dataclass(frozen=True, slots=True)
class Row:
    """One term that is linear in its coefficient θ.

    Attributes:
        name: of the effect or term.
        parts: on the axes on which it acts; most rows have one.
        low: θ is not below it.
        high: θ is not above it.
        drag: whether it has the axis's own velocity as a factor, so that it can drive or brake.
        follows: the signal that its own memory follows with a lag, read as `~` and its key; empty where it has none.
        lags: time constants from which the fit of the memory begins [s].
    """

    name: str
    parts: tuple[Part, ...]
    low: float = -INF
    high: float = INF
    drag: bool = False
    follows: str = ""
    lags: tuple[float, ...] = ()

    @property
    def axis(self) -> str:
        """The velocity of the axis on which it acts, the first of several."""
        return self.parts[0].axis

    @property
    def key(self) -> str:
        """Its name among the parameters."""
        return f"{self.name}@{self.axis}"


def row(name: str, axis: str, one: Factor, other: Factor = ONE, low: float = -INF, drag: bool = False) -> Row:
    """A row of one axis."""
    return Row(name, (Part(axis, one, other),), low=low, drag=drag)


def damping(rate: str) -> tuple[Row, ...]:
    """Linear and quadratic damping of an axis by its own velocity; neither drives."""
    return (
        row("linear", rate, value(rate), low=0.0, drag=True),
        row("quadratic", rate, size(rate), value(rate), low=0.0, drag=True),
    )


def bends(rate: str, fast: float, shares: Sequence[float] = (0.2, 0.4, 0.7)) -> tuple[Row, ...]:
    """Damping beside the linear and the quadratic one, so that its curve has any shape: an odd line with bends.

    Args:
        fast: a velocity that is seldom passed.
        shares: of it, at which the line bends.
    """
    return tuple(row(f"bend:{share:g}", rate, Factor("bend", rate, share * fast), drag=True) for share in shares)


def uneven(rate: str) -> tuple[Row, ...]:
    """What the linear and the quadratic damping are more to one side than to the other."""
    return (
        row("bend:uneven", rate, value(rate), value(rate), drag=True),
        row("bend:uneven linear", rate, size(rate), drag=True),
    )


def curves(rate: str, fast: float) -> dict[str, tuple[Row, ...]]:
    """Damping of yet another shape, by name: steeper at slow velocities, or more to one side than to the other.

    Args:
        fast: a velocity that is seldom passed.
    """
    return {"bend:slow": bends(rate, fast, (0.1,)), "bend:uneven": uneven(rate)}


def own(rate: str, fast: float, driven: bool) -> tuple[Row, ...]:
    """Effects of an axis's own velocity, its own effort and a constant.

    Args:
        fast: a velocity that is seldom passed.
        driven: whether an effort of its own is recorded.
    """
    sign = Factor("sign", rate, 0.03 * fast)  # friction turns its sign within it; no log resolves less
    found = [
        row("bias_torque", rate, ONE),
        row("coulomb", rate, sign, low=0.0, drag=True),
        row("coulomb_asymmetry", rate, sign, sign),
    ]
    if driven:
        found.append(row("inflow", rate, value(rate), Factor("root", effort_of(rate)), low=0.0))
    return tuple(found)


def gyro_zero(rate: str, linear: float, quadratic: float) -> dict[str, tuple[Row, ...]]:
    """A rate that a gyro shows too much, b: to first order −d′(r) b is missing of a damping d1 r + d2 |r| r.

    Where d is linear that is a constant moment: it has no row then.
    """
    if quadratic <= 0.0:
        return {}
    return {"gyro_bias": (row("gyro_bias", rate, Factor("raised", rate, linear / (2.0 * quadratic))),)}


def memory(rate: str, lags: Sequence[float]) -> Row:
    """Drag by past motion, because the water around the hull follows it with a lag."""
    return Row("memory", (Part(rate, value(f"~memory@{rate}")),), follows=rate, lags=tuple(lags))


def turned(rate: str) -> dict[str, tuple[Row, ...]]:
    """Moments that depend on the heading, by effect."""
    kinds = {"heading_current": ("sine", "cosine"), "heading_current:2": ("sine2", "cosine2")}
    found = {
        name: tuple(row(f"{name}:{kind}", rate, Factor(kind, "heading")) for kind in pair)
        for name, pair in kinds.items()
    }
    return found | {"tether": (row("tether", rate, value("heading")), row("bias_torque", rate, ONE))}


def of_time(rate: str, instants: Sequence[float], driven: bool) -> dict[str, tuple[Row, ...]]:
    """Changes during a recording, by effect; a step's name has its instant.

    Args:
        instants: at which damping or thrust may jump, in the time of the channel `time` [s].
    """
    found = {
        "bias_drift": (row("bias_drift", rate, value("time")), row("bias_torque", rate, ONE)),
        "drag_drift": (row("drag_drift", rate, value("time"), Factor("drag", rate), drag=True),),
    }
    if driven:
        found["thrust_drift"] = (row("thrust_drift", rate, value("time"), value(effort_of(rate))),)
    for instant in instants:
        after = Factor("after", "time", instant)
        found[f"drag_step:{instant:.4g}"] = (
            row(f"drag_step:{instant:.4g}", rate, after, Factor("drag", rate), drag=True),
        )
        if driven:
            found[f"thrust_step:{instant:.4g}"] = (
                row(f"thrust_step:{instant:.4g}", rate, after, value(effort_of(rate))),
            )
    return found


def waves(rate: str, frequencies: Sequence[float]) -> dict[str, tuple[Row, ...]]:
    """Periodic moments, by effect with its period; `frequencies` [rad/s]."""
    found = {}
    for frequency in frequencies:
        name = f"wave:{2.0 * math.pi / frequency:.4g}"
        pair = (Factor(kind, "time", frequency) for kind in ("wave", "wave_later"))
        found[name] = tuple(row(f"{name}:{one.kind}", rate, one) for one in pair)
    return found


def with_others(
    rate: str, others: Sequence[str], driven: bool, usual: Mapping[str, float] | None = None
) -> tuple[Row, ...]:
    """Effects of the body's other velocities on an axis, to second order.

    Args:
        others: velocities that are recorded, but the axis's own.
        driven: whether an effort of the axis is recorded.
        usual: their mean sizes, at which the thrust is as without them; where none is given, that at rest is.
    """
    found = list[Row]()
    for name in others:
        found.append(row(f"cross_flow:{name}", rate, size(name), value(rate), low=0.0, drag=True))
        found.append(row(f"coriolis:{name}*{rate}", rate, value(name), value(rate), drag=True))
        found.append(row(f"coupling:{name}", rate, value(name)))
        if driven:
            speed = Factor("raised", name, -usual[name]) if usual else size(name)
            found.append(row(f"thrust_speed:{name}", rate, speed, value(effort_of(rate))))
        if name in LATERAL and rate in LATERAL:
            found.append(row(f"coupling:|{name}|{name}", rate, size(name), value(name)))
        if rate not in LATERAL:
            found.append(row(f"square:{name}", rate, value(name), value(name)))
    for a, b in combinations(others, 2):
        found.append(row(f"coriolis:{a}*{b}", rate, value(a), value(b)))
    return tuple(found)


def of_channel(rate: str, name: str, mean: float, driven: bool) -> tuple[Row, ...]:
    """Effects of a channel that is no velocity: a moment in proportion to it, damping or thrust that it scales.

    Args:
        mean: of the channel, at which damping and thrust are as without it.
    """
    about = Factor("about", name, mean)
    found = [
        row(f"coupling:{name}", rate, value(name)),
        row(f"modulation:{name}", rate, about, Factor("drag", rate), drag=True),
    ]
    if driven:
        found.append(row(f"modulation:{name}:thrust", rate, about, value(effort_of(rate))))
    return tuple(found)


def efforts_of_others(rate: str, driven: Sequence[str]) -> tuple[Row, ...]:
    """Parts of other axes' efforts that act on this one, because thrusters are not aligned."""
    return tuple(row(f"effort:{name}", rate, value(effort_of(name))) for name in driven if name != rate)


def free_products(axes: Sequence[str]) -> tuple[Row, ...]:
    """The products of C(ν) ν of a diagonal M, each with a coefficient of its own."""
    return tuple(
        row(f"coriolis:{a}*{b}", axis.rate, value(a), value(b))
        for axis in AXES.values()
        for a, b in axis.products
        if a != b and {axis.rate, a, b} <= set(axes)
    )


def cross_damping(pairs: Sequence[tuple[str, str]]) -> tuple[Row, ...]:
    """Linear damping between axes, as Y_r and N_v (Fossen 2011, Eq. 6.85), of which each has a coefficient."""
    return tuple(row(f"coupling:{b}", a, value(b)) for one, other in pairs for a, b in ((one, other), (other, one)))


def restoring(axes: Sequence[str], recorded: Sequence[str]) -> tuple[Row, ...]:
    """Righting moments, and weight less buoyancy, where roll and pitch are recorded (Fossen 2011, Eq. 4.6)."""
    found = []
    down = {"surge": Factor("down_x"), "sway": Factor("down_y"), "heave": Factor("down_z")}
    if {"roll", "pitch"} <= set(recorded):
        if "roll_rate" in axes:
            found.append(row("righting", "roll_rate", down["sway"]))
        if "pitch_rate" in axes:
            found.append(Row("righting", (Part("pitch_rate", down["surge"], ONE, -1.0),)))
        if "heave" in axes:
            parts = [Part(axis, down[axis], ONE, -1.0) for axis in ("heave", "surge", "sway") if axis in axes]
            found.append(Row("weight", tuple(parts)))
    return tuple(found)


UNSIDED = (
    "cross_flow", "thrust_speed", "coulomb", "bend", "inflow", "linear", "quadratic", "memory", "bias_torque",
)  # fmt: skip
"""Rows that every hull may have."""


def mirrored(row: Row) -> bool:
    """Whether a hull whose port mirrors its starboard can have a row: both its sides change their sign, or neither."""
    kind, _, of = row.name.partition(":")
    names = [name.strip("|") for name in of.split("*")] if of else []
    odd = sum(name in LATERAL for name in names) % 2 == 1
    lateral = row.axis in LATERAL
    if kind in UNSIDED or not set(names) & set(VELOCITIES):
        return True
    if kind in ("coriolis", "coupling", "effort"):
        return odd == lateral
    return not lateral


def recorded_velocities(names: Sequence[str]) -> tuple[str, ...]:
    """The streams that are velocities of the body, in the order of ν."""
    return tuple(name for name in VELOCITIES if name in names)
