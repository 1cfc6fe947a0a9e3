"""The engine's effects in CONTRACT's words: name, streams, parameters, and the sentence on the physics.

A row opposes its axis's effort: a moment that acts is minus its θ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit
from incsvr.model.rows import Row
from incsvr.model.series import values
from incsvr.model.structure import Theta
from incsvr.plant.axes import VELOCITIES

Values = Mapping[str, float]
"""Parameters by the contract's names."""


@dataclass(frozen=True, slots=True)
class Here:
    """What the parameters of an effect refer to.

    Attributes:
        axis: the velocity of its axis.
        of: what the engine's name has behind its colon: a channel, a product, a period, an instant.
        rows: the model's rows by their keys.
        inertia: declared [kg], [kg m²].
        begin: the stamp at which the channel `time` is zero [s].
        length: of the recordings, from their first stamp to their last [s].
        between: two neighbouring instants at which a jump was tried [s].
        power: of each row of damping by its coefficient, the mean power that it takes, by its key.
        drag_power: the same of a row r |r|.
    """

    axis: str
    of: str
    rows: Mapping[str, Row]
    inertia: float
    begin: float
    length: float
    between: float
    power: Mapping[str, float]
    drag_power: float

    def share(self, theta: Theta) -> float:
        """The power of a row r |r| of coefficient one in that of the damping."""
        return self.drag_power / max(sum(theta[key] * each for key, each in self.power.items()), 1e-300)

    def width(self, name: str) -> float:
        """The width of the first factor of a row: an instant, a frequency or a mean."""
        return float(self.rows[f"{name}@{self.axis}"].parts[0].one.width)


Parameters = Callable[[Theta, Here], Values]
Unsure = Callable[[Here, Values, Values], Values]


def _nothing(_here: Here, _found: Values, _half: Values) -> Values:
    return {}


@dataclass(frozen=True, slots=True)
class Word:
    """An effect in the contract's words.

    Attributes:
        effect: the contract's name; {of} is what the engine's name has behind its colon.
        channels: the contract's streams that it reads; `{of}` likewise.
        parameters: from θ.
        sentence: the physics, a template of `AxisWords`.
        shown_by: what a recording must contain to show it, likewise.
        unsure: half widths of 95 % of parameters that are chosen and not fitted, from all parameters and their half
            widths.
        ties: names of what no recording distinguishes from it.
        apart: what does.
    """

    effect: str
    channels: tuple[str, ...]
    parameters: Parameters
    sentence: str
    shown_by: str
    unsure: Unsure = field(default=_nothing)
    ties: tuple[str, ...] = ()
    apart: str = "measure one of the two by other means (a bollard pull, a pendulum test)"


def here(found: Fit, name: str, inertia: float, begin: float, instants: int = 20) -> Here:
    """What the parameters of an effect of a fit refer to.

    Args:
        name: the engine's, with its axis.
        inertia: declared.
        begin: the stamp at which the channel `time` is zero [s].
        instants: at which `identification.pool` tries jumps.
    """
    effect, _, axis = name.partition("@")
    runs = found.problem.windows.runs
    rate = values(runs, axis)
    own = [row for row in found.structure.rows if row.name.partition(":")[0] in ("linear", "quadratic", "bend")]
    power = dict[str, float]()
    for row in own:
        if row.axis == axis:
            part = row.parts[0]
            taken = one_by_one(part.one, {axis: rate}) * one_by_one(part.other, {axis: rate})
            power[row.key] = float((taken * rate).mean())
    stamps = [run[axis][0] for run in runs]
    length = max(each[-1] for each in stamps) - min(each[0] for each in stamps)
    return Here(
        axis, effect.partition(":")[2], {row.key: row for row in found.structure.rows}, inertia, begin, float(length),
        float(length) / (instants + 1), power, float((rate * rate * abs(rate)).mean()),
    )  # fmt: skip


def word_of(name: str) -> Word:
    """The words of an effect by the engine's name.

    Raises:
        KeyError: the contract has no such effect of one axis.
    """
    kind, _, of = name.partition("@")[0].partition(":")
    return WORDS[f"{kind}:thrust" if kind == "modulation" and of.endswith(":thrust") else kind]


def contract_name(name: str) -> str:
    """The contract's name of an effect by the engine's."""
    kind, _, of = name.partition("@")[0].partition(":")
    of = of.removesuffix(":thrust")
    if kind == "coriolis":
        of = "*".join(sorted(of.split("*"), key=VELOCITIES.index))
    return word_of(name).effect.format(of=of)


def streams(name: str) -> tuple[str, ...]:
    """The contract's `channels` of an effect by the engine's name."""
    of = name.partition("@")[0].partition(":")[2].removesuffix(":thrust")
    found = []
    for each in word_of(name).channels:
        found += each.format(of=of).replace("|", "*").strip("*").split("*")
    own = name.partition("@")[2]
    return tuple(dict.fromkeys(each for each in found if each != own)) or ("yaw_rate",)


def _row(parameter: str, name: str, sign: float = 1.0) -> Parameters:
    """One parameter that is the coefficient of a row."""
    return lambda theta, here: {parameter: sign * theta[f"{name.format(of=here.of)}@{here.axis}"]}


def _stage(parameter: str, kind: str) -> Parameters:
    """One parameter whose logarithm is in θ."""
    return lambda theta, here: {parameter: math.exp(theta[f"{kind}:{here.axis}"])}


def _inertia(theta: Theta, here: Here) -> Values:
    return {"inertia_kg_m2": math.exp(theta[f"mass:{here.axis}"])}


def _delay(theta: Theta, here: Here) -> Values:
    return {"delay_s": theta[f"shift:{here.axis}"]}


def _friction(theta: Theta, here: Here) -> Values:
    both, uneven = theta.get(f"coulomb@{here.axis}", 0.0), theta[f"coulomb_asymmetry@{here.axis}"]
    return {"moment_forward_nm": both + uneven, "moment_backward_nm": both - uneven}


def _memory(theta: Theta, here: Here) -> Values:
    key = f"memory@{here.axis}"
    return {"gain_nm_s": -theta[key], "time_constant_s": math.exp(theta[f"time:{key}"])}


def _oscillation(sine: float, cosine: float) -> Values:
    """The moment −(s sin x + c cos x) as A sin(x + φ)."""
    return {"amplitude_nm": math.hypot(sine, cosine), "phase_rad": math.atan2(-cosine, -sine)}


def _heading(theta: Theta, here: Here) -> Values:
    name, two = ("heading_current:2", "2") if here.of == "2" else ("heading_current", "")
    sine, cosine = (theta[f"{name}:{kind}{two}@{here.axis}"] for kind in ("sine", "cosine"))
    return {**_oscillation(sine, cosine), "harmonic": 2.0 if two else 1.0}


def _wave(theta: Theta, here: Here) -> Values:
    name = f"wave:{here.of}:wave"
    sine, cosine = theta[f"{name}@{here.axis}"], theta[f"{name}_later@{here.axis}"]
    return {**_oscillation(sine, cosine), "period_s": 2.0 * math.pi / here.width(name)}


def _unsure_wave(here: Here, found: Values, half: Values) -> Values:
    """The frequency is a line of a spectrum of four times the length; its own error is √12 relative errors of the
    amplitude in a length (D. C. Rife & R. R. Boorstyn, IEEE Trans. Inf. Theory 20, 1974)."""
    own = math.sqrt(12.0) * half["amplitude_nm"] / max(found["amplitude_nm"], 1e-300)
    frequency = math.hypot(own, math.pi / 4.0) / here.length
    return {
        "period_s": found["period_s"] ** 2 / (2.0 * math.pi) * frequency,
        "phase_rad": 0.5 * frequency * here.length,
    }


def _tether(theta: Theta, here: Here) -> Values:
    stiffness = theta[f"tether@{here.axis}"]
    constant = theta.get(f"bias_torque@{here.axis}", 0.0)
    return {"stiffness_nm_per_rad": stiffness, "neutral_rad": -constant / stiffness if stiffness else 0.0}


def _bias_drift(theta: Theta, here: Here) -> Values:
    return {
        "nm_per_s": -theta[f"bias_drift@{here.axis}"],
        "start_nm": -theta.get(f"bias_torque@{here.axis}", 0.0),
    }


def _drag_drift(theta: Theta, here: Here) -> Values:
    return {"fraction": theta[f"drag_drift@{here.axis}"] * here.length * here.share(theta)}


def _drag_step(theta: Theta, here: Here) -> Values:
    name = f"drag_step:{here.of}"
    return {"fraction": theta[f"{name}@{here.axis}"] * here.share(theta), "at_s": here.begin + here.width(name)}


def _thrust_drift(theta: Theta, here: Here) -> Values:
    return {"fraction": -theta[f"thrust_drift@{here.axis}"] * here.length}


def _thrust_step(theta: Theta, here: Here) -> Values:
    name = f"thrust_step:{here.of}"
    return {"fraction": -theta[f"{name}@{here.axis}"], "at_s": here.begin + here.width(name)}


def _unsure_instant(here: Here, _found: Values, _half: Values) -> Values:
    return {"at_s": here.between}


def _modulation(theta: Theta, here: Here) -> Values:
    name = f"modulation:{here.of}"
    return {"coefficient": theta[f"{name}@{here.axis}"] * here.share(theta), "reference": here.width(name)}


def _thrust_modulation(theta: Theta, here: Here) -> Values:
    name = f"modulation:{here.of}"
    return {"coefficient": -theta[f"{name}@{here.axis}"], "reference": here.width(name)}


def _gyro_bias(theta: Theta, here: Here) -> Values:
    return {"rate_rad_s": -0.5 * theta[f"gyro_bias@{here.axis}"] / max(theta[f"quadratic@{here.axis}"], 1e-300)}


def _coriolis(theta: Theta, here: Here) -> Values:
    coefficient = theta[f"coriolis:{here.of}@{here.axis}"]
    return {"coefficient": coefficient, "ratio": coefficient / here.inertia}


def _square(theta: Theta, here: Here) -> Values:
    coefficient = theta[f"square:{here.of}@{here.axis}"]
    return {"coefficient": coefficient, "ratio": coefficient / here.inertia}


_THRUST, _MOTION, _HEADING, _CLOCK, _CHANNEL = ("torque",), ("yaw_rate",), ("heading",), ("t",), ("{of}",)
_PRODUCT = "the product of two velocities {drives} the vehicle: Coriolis and centripetal terms, Munk moment, and lift"
_BOTH_SIGNS = "both velocities together, each with both signs if it has them"

WORDS: dict[str, Word] = {
    "bias_torque": Word(
        "bias_torque", (), _row("moment_nm", "bias_torque", -1.0),
        "a constant {name} {moment} N₀ acts beside the thrusters: trim, a bent fin or a thruster offset",
        "{effort}s of both signs and of several sizes",
    ),
    "inertia": Word(
        "inertia", _MOTION, _inertia, "the {inertia_with_added_mass}, {added_mass}, differs from the declared one",
        "{effort}s that change so fast that the {inertia} counts as much as the damping", ties=("thrust_efficiency",),
    ),
    "lag": Word(
        "torque_lag", _THRUST, _stage("time_constant_s", "lag"),
        "the thrust follows the command with first-order rotor dynamics of time constant T",
        "sudden changes of the command", ties=("gyro_lag",), apart="log the gyro raw, without its filter",
    ),
    "delay": Word(
        "torque_delay", _THRUST, _delay,
        "the thrust follows its command after a dead time D, or the clocks of the two streams are D apart",
        "sudden changes of the command, and stamps of one clock",
    ),
    "dead": Word(
        "dead_zone", _THRUST, _stage("half_width_nm", "dead"),
        "the thrusters have a dead band: they give nothing while the commanded {moment} is small",
        "small commands within the band, beside larger ones",
    ),
    "reverse": Word(
        "torque_asymmetry", _THRUST, _stage("reverse_efficiency", "reverse"),
        "the thrust efficiency of the negative (reverse) direction differs from that of the positive one",
        "{effort}s of both signs and of several sizes",
    ),
    "limit": Word(
        "torque_saturation", _THRUST, _stage("limit_nm", "limit"), "the thrust is cut at a limit",
        "commands beyond the limit, beside smaller ones",
    ),
    "exponent": Word(
        "thrust_curve", _THRUST, _stage("exponent", "exponent"),
        "the thrust follows another power of the command than its table's, as the square of a rotor's speed",
        "commands of many sizes",
    ),
    "inflow": Word(
        "inflow", ("yaw_rate", "torque"), _row("coefficient", "inflow"),
        "the thruster's inflow, from the vehicle's own turning, takes thrust in proportion to r and the rotor speed",
        "large and small {effort}s at the same {rate}",
    ),
    "heading_current": Word(
        "heading_current", _HEADING, _heading,
        "a {moment} that depends on heading: a current's drag (once a turn) or its Munk moment (twice a turn)",
        "motion through many headings, best in full turns, with a measured heading",
    ),
    "gyro_bias": Word(
        "gyro_bias", _MOTION, _gyro_bias,
        "the gyro's zero is off: it shows a constant rate where the vehicle does not turn, and no {moment} acts",
        "fast and slow motion, and a measured heading: without one it looks like a constant {moment}",
    ),
    "tether": Word(
        "tether", _HEADING, _tether,
        "a tether {draws} the vehicle back with a {moment} that grows with the turned angle",
        "turns to both sides that twist the tether, with a measured heading",
    ),
    "wave": Word(
        "wave", _CLOCK, _wave, "a periodic {moment} acts that depends on time alone, as of regular waves",
        "many periods, with commands of other periods", _unsure_wave,
    ),
    "drag_drift": Word(
        "drag_drift", _CLOCK, _drag_drift,
        "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} drifts over the recording, as with fouling",
        "the same {rates} early and late in the recordings",
    ),
    "drag_step": Word(
        "drag_step", _CLOCK, _drag_step,
        "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} jumps at one instant: another hull, a payload, "
        "something caught",
        "the same {rates} before and after the instant", _unsure_instant,
    ),
    "memory": Word(
        "memory", _MOTION, _memory,
        "the damping depends on the past of the {rate}: co-rotating water or unsteady flow (fluid memory)",
        "fast reversals, and steady motion of several time constants T",
    ),
    "coulomb": Word(
        "coulomb", _MOTION, _row("moment_nm", "coulomb"),
        "dry (Coulomb) friction: a {moment} of constant size against the {sense}",
        "slow motion in both directions, beside fast motion",
    ),
    "coulomb_asymmetry": Word(
        "coulomb_asymmetry", _MOTION, _friction,
        "dry (Coulomb) friction that differs with the direction of the turn",
        "slow motion in both directions, with stops",
    ),
    "bias_drift": Word(
        "bias_drift", _CLOCK, _bias_drift,
        "a {name} {moment} drifts slowly with time: changing trim, leakage, a warming thruster driver",
        "a long time with {effort}s of both signs",
    ),
    "thrust_step": Word(
        "thrust_step", _CLOCK, _thrust_step,
        "the thrust jumps at one instant: a thruster fails or is fouled, or one comes back",
        "the same {effort}s before and after the instant", _unsure_instant,
    ),
    "thrust_drift": Word(
        "thrust_drift", _CLOCK, _thrust_drift,
        "the thrust drifts over the recording, as with the charge of a battery",
        "the same {effort}s early and late in the recordings",
    ),
    "thrust_speed": Word(
        "thrust_speed", _CHANNEL, _row("coefficient", "thrust_speed:{of}", -1.0),
        "the thrust depends on the advance speed: a propeller's falls with it, a rudder's grows with its square",
        "the same {effort}s at several surge velocities",
    ),
    "coriolis": Word("coriolis:{of}", _CHANNEL, _coriolis, _PRODUCT, _BOTH_SIGNS),
    "square": Word("coriolis:{of}*{of}", _CHANNEL, _square, _PRODUCT, _BOTH_SIGNS),
    "cross_flow": Word(
        "cross_flow:{of}", _CHANNEL, _row("coefficient", "cross_flow:{of}"),
        "the damping grows with the size of another velocity: cross-flow drag, or damping by speed",
        "several {rates} while x is slow and while it is fast",
    ),
    "coupling": Word(
        "coupling:{of}", _CHANNEL, _row("coefficient", "coupling:{of}", -1.0),
        "a {name} {moment} follows another channel (hydrodynamic coupling as N_v, or an actuator of another axis)",
        "several values of the channel at the same {effort} and {rate}",
    ),
    "modulation": Word(
        "modulation:{of}", _CHANNEL, _modulation, "the damping is scaled by another channel",
        "several values of the channel at the same {rate}",
    ),
    "modulation:thrust": Word(
        "modulation:{of}", _CHANNEL, _thrust_modulation,
        "the thrust is scaled by another channel, as by the supply voltage",
        "several values of the channel at the same {effort}",
    ),
}  # fmt: skip
"""By the kind of the engine's effect."""
