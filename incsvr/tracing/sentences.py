"""Findings in plain words, with the literature's terms and units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from incsvr.plant.words import AxisWords, words_of
from incsvr.tracing.answering import Loop
from incsvr.tracing.findings import Trace

LABELS = {
    "moment_nm": ("moment", "{effort_unit}"),
    "inertia_kg_m2": ("{moment_of_inertia}", "{inertia_unit}"),
    "time_constant_s": ("time constant", "s"),
    "delay_s": ("delay", "s"),
    "half_width_nm": ("half width", "{effort_unit}"),
    "reverse_efficiency": ("reverse efficiency", ""),
    "limit_nm": ("limit", "{effort_unit}"),
    "coefficient": ("coefficient", ""),
    "amplitude_nm": ("amplitude", "{effort_unit}"),
    "phase_rad": ("phase", "rad"),
    "harmonic": ("periods in a turn", ""),
    "stiffness_nm_per_rad": ("stiffness", "{stiffness_unit}"),
    "neutral_rad": ("neutral heading", "rad"),
    "slack_rad": ("slack to either side", "rad"),
    "period_s": ("period", "s"),
    "fraction": ("relative change", ""),
    "at_s": ("at", "s"),
    "gain_nm_s": ("gain", "{effort_unit} s"),
    "nm_per_s": ("drift", "{effort_unit}/s"),
    "start_nm": ("at the start", "{effort_unit}"),
    "reference": ("reference level", ""),
    "exponent": ("exponent", ""),
    "rate_rad_s": ("rate", "rad/s"),
    "moment_forward_nm": ("{moment} forward", "{effort_unit}"),
    "moment_backward_nm": ("{moment} backward", "{effort_unit}"),
    "ratio": ("in parts of the declared {inertia}", ""),
}
"""Parameter → what to call it, and its unit: templates of `AxisWords`."""


AHEAD = (
    "the vehicle turns before its {effort} is recorded, which is impossible: the {effort}'s stamps are late by |D| "
    "against the {rate}'s, or another effect causes it"
)
"""The sentence on a negative delay."""


def of_loop(loop: Loop, words: AxisWords) -> tuple[str, ...]:
    """The note on a controller whose gyro this log may not hold; empty where nothing is in doubt."""
    if loop is not Loop.OTHER_GYRO:
        return ()
    return (
        f"the {words.effort} responds to the rate, but this log's gyro does not predict the {words.effort}: the "
        f"controller reads another gyro, or the {words.effort} is measured; no effect was sought, because each might "
        "be false; log the controller's own gyro, or give --set signals.torque=measured",
    )


def of_share(share: float) -> tuple[str, ...]:
    """The note that long recordings were thinned; empty where all of them was fitted."""
    if share >= 1.0:
        return ()
    return (f"{share:.0%} of the recordings were fitted, in stretches spread evenly over them: they are long enough",)


MUCH_LEFT_SHARE = 0.25
"""Part of the torque that a model leaves from which the headline says so: a thrust table is known to about a tenth."""
NAMED_EFFECTS = 3
"""Effects that a headline names; it counts the others."""


def headline(found: Trace) -> str:
    """The headline of a trace, one clause: its verdict with the error on unseen data that decides it."""
    words = words_of(found.axis)
    if not found.beats_zero:
        return "the model predicts no better than a rate of zero"
    if not found.proven and found.error["trivial"]["hold"]["free_run_rmse"] < found.error["after"]["free_run_rmse"]:
        return "the model predicts no better than the first rate held"
    if found.verdict == "effects":
        key, names = found.decisive_error, _named([finding.effect for finding in found.effects])
        before, after = (f"{found.error[when][key]:.3g}" for when in ("before", "after"))
        called, unit = _error(key, words)
        if found.proven:
            return f"adding {names} lowers {called} on unseen data from {before} to {after} {unit}"
        if found.error["change"][key]["low"] > 0.0:
            return f"adding {names} raises {called} on unseen data from {before} to {after} {unit}"
        return f"{called} on unseen data does not prove {names}: {before} {unit} without, {after} with"
    if found.verdict == "unexplained" and not found.sought:
        return f"no effect was sought because of a controller with another gyro or a measured {words.effort}"
    if found.verdict == "unexplained":
        follows = _named([each.channel for each in found.unexplained])
        return f"no known effect explains {f'how the residual follows {follows}' if follows else 'the large residual'}"
    left = left_of_torque(found.error)
    if left is not None and left >= MUCH_LEFT_SHARE:
        return f"the model leaves {_share(left, words)} unexplained by any known effect"
    return "the model lacks nothing that these recordings show"


def limits(found: Trace) -> list[str]:
    """What limits the headline, a clause each."""
    found_limits, left, words = list(found.doubts), left_of_torque(found.error), words_of(found.axis)
    if not found.beats_zero:
        found_limits.append(f"check {words.inertia}, units and signs before anything else")
    elif found.verdict != "none" and left is not None and left >= MUCH_LEFT_SHARE:
        found_limits.append(f"the residual is {_share(left, words)}")
    other = "free_run_rmse" if found.decisive_error == "torque_rmse" else "torque_rmse"
    if found.verdict != "none" and found.error["change"][other]["low"] > 0.0:
        before, after = (f"{found.error[when][other]:.3g}" for when in ("before", "after"))
        called, unit = _error(other, words)
        found_limits.append(f"on unseen data {called} grows from {before} to {after} {unit}")
    if not found.one_clock:
        found_limits.append("effects that begin or drift were not sought: the stamps of the recordings overlap")
    return found_limits


def proof(found: Trace) -> str:
    """What the errors on unseen data prove."""
    if not found.beats_zero:
        return "not proven: the error of the free run exceeds that of a zero rate"
    change, effort = found.error["change"][found.decisive_error], words_of(found.axis).effort
    by = "lower" if change["high"] < 0.0 else "higher" if change["low"] > 0.0 else ""
    judged = f"is significantly {by}" if by else "does not differ significantly"
    if found.loop != "closed":
        return f"open loop: the error of the free run on unseen data {judged}"
    but = ", but not proven: the free run errs more" if by == "lower" and found.effects and not found.proven else ""
    return (
        f"closed loop: a free run proves nothing, because the {effort} reacts to disturbances; the error of the "
        f"predicted {effort} on unseen data {judged}{but}"
    )


def _named(names: Sequence[str]) -> str:
    """Names in one phrase."""
    listed = [*names[:NAMED_EFFECTS], *([f"{len(names) - NAMED_EFFECTS} more"] if len(names) > NAMED_EFFECTS else [])]
    return " and ".join([", ".join(listed[:-1]), listed[-1]] if len(listed) > 1 else listed)


def _error(key: str, words: AxisWords) -> tuple[str, str]:
    """What an error is called, and its unit."""
    return {
        "torque_rmse": (f"the {words.effort}'s error", words.effort_unit),
        "free_run_rmse": ("the free run's error", words.rate_unit),
    }[key]


def left_of_torque(error: Mapping[str, Any]) -> float | None:
    """Part of the torque that the model leaves of the fitted recordings; None where there was no torque."""
    share = error["disturbance"].get("share_of_torque")
    return None if share is None else float(share)


def _share(left: float, words: AxisWords) -> str:
    return f"{100.0 * left:.0f} % of the {words.effort}"


MIN_SAID_P_VALUE = 1e-300
"""p-value below which a number no longer says how small it is: floating point ends at 1e-308."""


def chance(p_value: float, digits: int = 2) -> str:
    """A p-value behind its p: "= 0.012", or "< 1e-300" where it has become zero, as no chance is."""
    return f"< {MIN_SAID_P_VALUE:g}" if p_value < MIN_SAID_P_VALUE else f"= {p_value:.{digits}g}"
