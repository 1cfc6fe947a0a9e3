"""The engine's effects in CONTRACT's words: name, streams, parameters, and the sentence on the physics."""

from __future__ import annotations

from dataclasses import dataclass, field

from incsvr.plant.axes import VELOCITIES
from incsvr.tracing.effect_values import (
    Parameters,
    Unsure,
    bias_drift_values,
    coriolis_values,
    delay_values,
    drag_drift_values,
    drag_step_values,
    friction_values,
    gyro_bias_values,
    heading_values,
    inertia_values,
    memory_values,
    modulation_values,
    nothing_unsure,
    of_row,
    of_stage,
    square_values,
    tether_values,
    thrust_drift_values,
    thrust_modulation_values,
    thrust_speed_values,
    thrust_step_values,
    unsure_delay,
    unsure_instant,
    unsure_wave,
    wave_values,
)


@dataclass(frozen=True, slots=True)
class Word:
    """An effect in the contract's words.

    Attributes:
        effect: the contract's name; {of} is what the engine's name has behind its colon.
        channels: the contract's streams that it reads; `{of}` likewise.
        parameters: from θ.
        equation: how it changes I ṙ + d(r) = τ; a is what the thrusters make of the command τ.
        sentence: the physics, a template of `AxisWords`.
        shown_by: what a recording must contain to show it, likewise.
        unsure: half widths of 95 % of parameters that are chosen and not fitted, from all parameters and their half
            widths.
        ties: names of what no recording distinguishes from it.
        apart: what does.
        shape: which of the shapes of an effect that has several; empty for its usual one.
    """

    effect: str
    channels: tuple[str, ...]
    parameters: Parameters
    equation: str
    sentence: str
    shown_by: str
    unsure: Unsure = field(default=nothing_unsure)
    ties: tuple[str, ...] = ()
    apart: str = "measure one of the two by other means (a bollard pull, a pendulum test)"
    shape: str = ""


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


_THRUST, _MOTION, _HEADING, _CLOCK, _CHANNEL = ("torque",), ("yaw_rate",), ("heading",), ("t",), ("{of}",)
_PRODUCT = "the product of two velocities {drives} the vehicle: Coriolis and centripetal terms, Munk moment, and lift"
_BOTH_SIGNS = "both velocities together, each with both signs if it has them"

ROTOR_SPEED = "rotor speed"
"""The shape of a lag of the rotors' speed, whose square the thrust follows."""

WORDS: dict[str, Word] = {
    "bias_torque": Word(
        "bias_torque", (), of_row("moment_nm", "bias_torque", -1.0),
        "I ṙ + d(r) = τ + N₀",
        "a constant {name} {moment} N₀ acts beside the thrusters: trim, a bent fin or a thruster offset",
        "{effort}s of both signs and of several sizes",
    ),
    "inertia": Word(
        "inertia", _MOTION, inertia_values,
        "I ṙ + d(r) = τ with another I than the declared",
        "the {inertia_with_added_mass}, {added_mass}, differs from the declared one",
        "{effort}s that change so fast that the {inertia} counts as much as the damping", ties=("thrust_efficiency",),
    ),
    "lag": Word(
        "torque_lag", _THRUST, of_stage("time_constant_s", "lag"),
        "T ȧ + a = τ",
        "the thrust follows the command with first-order rotor dynamics of time constant T",
        "sudden changes of the command", ties=("gyro_lag",), apart="log the gyro raw, without its filter",
    ),
    "spin": Word(
        "torque_lag", _THRUST, of_stage("time_constant_s", "spin"),
        "T ṅ + n = sgn(τ) √|τ|, a = n |n|",
        "the speed n of the rotors follows the command with time constant T, and the thrust goes with its square",
        "sudden changes of the command", ties=("gyro_lag",), apart="log the gyro raw, without its filter",
        shape=ROTOR_SPEED,
    ),
    "delay": Word(
        "torque_delay", _THRUST, delay_values,
        "a(t) = τ(t − D)",
        "the thrust follows its command after a dead time D, or the clocks of the two streams are D apart",
        "sudden changes of the command, and stamps of one clock", unsure=unsure_delay,
    ),
    "dead": Word(
        "dead_zone", _THRUST, of_stage("half_width_nm", "dead"),
        "a = 0 for |τ| < w, a = τ − w sgn(τ) otherwise",
        "the thrusters have a dead band: they give nothing while the commanded {moment} is small",
        "small commands within the band, beside larger ones",
    ),
    "gap": Word(
        "dead_zone", _THRUST, of_stage("half_width_nm", "gap"),
        "a = 0 for |τ| < w, a = τ otherwise",
        "the thrusters have a dead band: they give nothing while the commanded {moment} is small, and all of it beyond",
        "small commands within the band, beside larger ones",
        shape="step",
    ),
    "reverse": Word(
        "torque_asymmetry", _THRUST, of_stage("reverse_efficiency", "reverse"),
        "a = e τ for τ < 0, a = τ otherwise",
        "the thrust efficiency of the negative (reverse) direction differs from that of the positive one",
        "{effort}s of both signs and of several sizes",
    ),
    "limit": Word(
        "torque_saturation", _THRUST, of_stage("limit_nm", "limit"),
        "a = τ for |τ| < L, a = L sgn(τ) otherwise", "the thrust is cut at a limit",
        "commands beyond the limit, beside smaller ones",
    ),
    "sag": Word(
        "torque_saturation", _THRUST, of_stage("limit_nm", "sag"),
        "a = τ / (1 + |τ/L|³)^⅓", "the thrust falls short by and by and bends to a limit L",
        "commands near the limit and beyond, beside smaller ones",
        shape="bend",
    ),
    "exponent": Word(
        "thrust_curve", _THRUST, of_stage("exponent", "exponent"),
        "a = τ₀ sgn(τ) |τ/τ₀|^p, with the highest command τ₀",
        "the thrust follows another power of the command than its table's, as the square of a rotor's speed",
        "commands of many sizes",
    ),
    "inflow": Word(
        "inflow", ("yaw_rate", "torque"), of_row("coefficient", "inflow"),
        "I ṙ + d(r) + c r √|a| = a",
        "the thruster's inflow, from the vehicle's own turning, takes thrust in proportion to r and the rotor speed",
        "large and small {effort}s at the same {rate}",
    ),
    "heading_current": Word(
        "heading_current", _HEADING, heading_values,
        "I ṙ + d(r) = τ + A sin(n ψ + φ), n one or two",
        "a {moment} that depends on heading: a current's drag (once a turn) or its Munk moment (twice a turn)",
        "motion through many headings, best in full turns, with a measured heading",
    ),
    "gyro_bias": Word(
        "gyro_bias", _MOTION, gyro_bias_values,
        "I ṙ + d(r − b) = τ",
        "the gyro's zero is off: it shows a constant rate where the vehicle does not turn, and no {moment} acts",
        "fast and slow motion, and a measured heading: without one it looks like a constant {moment}",
    ),
    "tether": Word(
        "tether", _HEADING, tether_values,
        "I ṙ + d(r) + k (ψ − ψ₀) = τ",
        "a tether {draws} the vehicle back with a {moment} that grows with the turned angle",
        "turns to both sides that twist the tether, with a measured heading",
    ),
    "wave": Word(
        "wave", _CLOCK, wave_values,
        "I ṙ + d(r) = τ + A sin(2π t/P + φ)",
        "a periodic {moment} acts that depends on time alone, as of regular waves",
        "many periods, with commands of other periods", unsure_wave,
    ),
    "drag_drift": Word(
        "drag_drift", _CLOCK, drag_drift_values,
        "I ṙ + d(r) + c t r |r| = τ; f is the share of the damping's mean power that this takes at the end",
        "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} drifts over the recording, as with fouling",
        "the same {rates} early and late in the recordings",
    ),
    "drag_step": Word(
        "drag_step", _CLOCK, drag_step_values,
        "I ṙ + d(r) + c r |r| = τ from the instant t_s on; f is the share of the damping's mean power",
        "the damping {linear}, {force_symbol}_{{{symbol}|{symbol}|}} jumps at one instant: a cover, a payload, "
        "something caught",
        "the same {rates} before and after the instant", unsure_instant,
    ),
    "memory": Word(
        "memory", _MOTION, memory_values,
        "I ṙ + d(r) − g m = τ, T ṁ = r − m",
        "the damping depends on the past of the {rate}: co-rotating water or unsteady flow (fluid memory)",
        "fast reversals, and steady motion of several time constants T",
    ),
    "coulomb": Word(
        "coulomb", _MOTION, of_row("moment_nm", "coulomb"),
        "I ṙ + d(r) + N_c tanh(r/r_c) = τ, with a small creep rate r_c",
        "dry (Coulomb) friction: a {moment} of constant size against the {sense}",
        "slow motion in both directions, beside fast motion",
    ),
    "coulomb_asymmetry": Word(
        "coulomb_asymmetry", _MOTION, friction_values,
        "I ṙ + d(r) + N_c tanh(r/r_c) = τ, with one N_c for r > 0 and another for r < 0",
        "dry (Coulomb) friction that differs with the direction of the turn",
        "slow motion in both directions, with stops",
    ),
    "bias_drift": Word(
        "bias_drift", _CLOCK, bias_drift_values,
        "I ṙ + d(r) = τ + N₀ + ν t",
        "a {name} {moment} drifts slowly with time: changing trim, leakage, a warming thruster driver",
        "a long time with {effort}s of both signs",
    ),
    "thrust_step": Word(
        "thrust_step", _CLOCK, thrust_step_values,
        "a = τ, from the instant t_s on a = (1 + f) τ",
        "the thrust jumps at one instant: a thruster fails or is fouled, or one comes back",
        "the same {effort}s before and after the instant", unsure_instant,
    ),
    "thrust_drift": Word(
        "thrust_drift", _CLOCK, thrust_drift_values,
        "a = (1 + f p) τ, p from 0 to 1 over the recordings",
        "the thrust drifts over the recording, as with the charge of a battery",
        "the same {effort}s early and late in the recordings",
    ),
    "thrust_speed": Word(
        "thrust_speed", _CHANNEL, thrust_speed_values,
        "a = (1 + c (|x| − x̄)) τ, with the mean x̄ of |x|",
        "the thrust depends on the advance speed: a propeller's falls with it, a rudder's grows with its square",
        "the same {effort}s at several surge velocities",
    ),
    "coriolis": Word("coriolis:{of}", _CHANNEL, coriolis_values,
        "I ṙ + d(r) + c x y = τ with the velocities x and y", _PRODUCT, _BOTH_SIGNS),
    "square": Word("coriolis:{of}*{of}", _CHANNEL, square_values,
        "I ṙ + d(r) + c x² = τ", _PRODUCT, _BOTH_SIGNS),
    "cross_flow": Word(
        "cross_flow:{of}", _CHANNEL, of_row("coefficient", "cross_flow:{of}"),
        "I ṙ + d(r) + c |x| r = τ",
        "the damping grows with the size of another velocity: cross-flow drag, or damping by speed",
        "several {rates} while x is slow and while it is fast",
    ),
    "coupling": Word(
        "coupling:{of}", _CHANNEL, of_row("coefficient", "coupling:{of}", -1.0),
        "I ṙ + d(r) = τ + c x",
        "a {name} {moment} follows another channel (hydrodynamic coupling as N_v, or an actuator of another axis)",
        "several values of the channel at the same {effort} and {rate}",
    ),
    "modulation": Word(
        "modulation:{of}", _CHANNEL, modulation_values,
        "I ṙ + d(r) + k (x − x̄) r |r| = τ, with the mean x̄; c is k's share of the damping's mean power",
        "the damping is scaled by another channel",
        "several values of the channel at the same {rate}",
    ),
    "modulation:thrust": Word(
        "modulation:{of}", _CHANNEL, thrust_modulation_values,
        "a = (1 + c (x − x̄)) τ, with the mean x̄",
        "the thrust is scaled by another channel, as by the supply voltage",
        "several values of the channel at the same {effort}",
    ),
}  # fmt: skip
"""By the kind of the engine's effect."""
