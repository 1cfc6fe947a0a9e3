"""Findings in plain words, with the literature's terms and units."""

from __future__ import annotations

from collections.abc import Mapping

from incsvr.effects import Effect, Signals

LABELS = {
    "moment_nm": ("moment", "N m"),
    "inertia_kg_m2": ("moment of inertia", "kg m²"),
    "time_constant_s": ("time constant", "s"),
    "delay_s": ("delay", "s"),
    "half_width_nm": ("half width", "N m"),
    "reverse_efficiency": ("reverse efficiency", ""),
    "limit_nm": ("limit", "N m"),
    "coefficient": ("coefficient", ""),
    "amplitude_nm": ("amplitude", "N m"),
    "phase_rad": ("phase", "rad"),
    "harmonic": ("periods in a turn", ""),
    "stiffness_nm_per_rad": ("stiffness", "N m/rad"),
    "neutral_rad": ("neutral heading", "rad"),
    "slack_rad": ("slack to either side", "rad"),
    "period_s": ("period", "s"),
    "fraction": ("relative change", ""),
    "at_s": ("at", "s"),
    "gain_nm_s": ("gain", "N m s"),
    "nm_per_s": ("drift", "N m/s"),
    "start_nm": ("at the start", "N m"),
    "reference": ("reference level", ""),
    "exponent": ("exponent", ""),
    "rate_rad_s": ("rate", "rad/s"),
    "moment_forward_nm": ("moment forward", "N m"),
    "moment_backward_nm": ("moment backward", "N m"),
    "ratio": ("in parts of the declared inertia", ""),
}
"""Parameter → what to call it, and its unit."""


AHEAD = (
    "the vehicle turns before its torque is recorded, which no thruster does: the torque's stamps are late by |D| "
    "against the yaw rate's, or another effect stands behind it"
)
"""What a negative delay means."""


def sentence(
    effect: Effect, parameters: Mapping[str, float], interval: Mapping[str, tuple[float, float]], explained_part: float
) -> str:
    """What was found, its values with 95 % intervals, and how much of the residual it explains."""
    values = []
    for name, value in parameters.items():
        label, unit = LABELS[name]
        low, high = interval[name]
        certain = high - low <= 0.0
        spread = "" if certain else f" ({low:.3g} to {high:.3g})"
        values.append(f"{label} {value:.3g}{spread}{' ' + unit if unit else ''}")
    meaning = AHEAD if parameters.get("delay_s", 0.0) < 0.0 else effect.sentence
    return f"{effect.name}: {meaning}; {', '.join(values)}. It explains {explained_part:.0%} of what can be explained."


def streams(effect: Effect) -> tuple[str, ...]:
    """The streams that an effect reads, for the contract's `channels`."""
    if effect.channels:
        return effect.channels
    if effect.acts == "thrust":
        return ("torque",)
    if effect.name in ("heading_current", "tether"):
        return ("heading",)
    if effect.name == "inflow":
        return ("yaw_rate", "torque")
    if effect.needs_clock:
        return ("t",)
    return () if effect.acts == "outside" else ("yaw_rate",)


def of_clocks(signals: Signals) -> tuple[str, ...]:
    """The note that nothing was sought that changes in time; empty where the recordings follow one another."""
    if signals.one_clock:
        return ()
    return (
        "the stamps of the recordings overlap, so each counts its own time: nothing was sought that begins or drifts "
        "at some time; recordings of one dive need stamps that go on from one to the next",
    )


SMALLEST = 1e-300
"""p-value below which a number no longer says how small it is: floating point ends at 1e-308."""


def chance(p_value: float, digits: int = 2) -> str:
    """A p-value behind its p: "= 0.012", or "< 1e-300" where it has become zero, as no chance is."""
    return f"< {SMALLEST:g}" if p_value < SMALLEST else f"= {p_value:.{digits}g}"
