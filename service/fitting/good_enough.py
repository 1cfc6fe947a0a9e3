"""Is a model good enough for what it is for? The error that counts for each use, its threshold, the verdict in words.

Each threshold is a share of what the use has without the model, because only the user knows an absolute one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from incsvr.plant.words import AxisWords

MAX_TORQUE_SHARE = 0.5
"""Feed-forward: the torque's error over the torque. Beyond a half, the controller still makes most of the torque."""
MAX_MOTION_SHARE = 0.5
"""Without a gyro: the free run's error over that of the better of zero and hold. At a half, the heading is lost half as
fast as without a model."""
MAX_CHANGE_SHARE = 0.3
"""Noticing: the smallest change of the damping that shows. Slime adds up to 20 % to a hull's drag, small shells 34 %
(Schultz 2007): beyond 30 %, only a heavily fouled hull shows."""
LITTLE_SHARE = 0.8
"""A free run that errs by more than this share of zero or hold shows hardly any motion."""
AHEAD_S = 10.0
"""The time after which the heading's error is stated [s]."""


@dataclass(frozen=True, slots=True)
class Use:
    """The verdict on one use of a model; `share` is what is compared with `limit`, None where it is not known."""

    use: str
    share: float | None
    limit: float
    why: str

    @property
    def verdict(self) -> str:
        return "unknown" if self.share is None else "yes" if self.share <= self.limit else "no"

    def to_dict(self) -> dict[str, Any]:
        share = None if self.share is None or math.isinf(self.share) else self.share
        return {"share": share, "limit": self.limit, "verdict": self.verdict, "why": self.why}


def unknown(use: str, limit: float, why: str) -> Use:
    return Use(use, None, limit, why)


def feed_forward(error: float, effort: float, words: AxisWords) -> Use:
    """The verdict by the error of the torque on unseen data, and the torque's size, both RMS [N m]."""
    share = error / effort if effort > 0.0 else math.inf
    why = f"{_percent(share)} of the {words.effort} is missed on unseen data (at most {_percent(MAX_TORQUE_SHARE)})"
    return Use("feed-forward", share, MAX_TORQUE_SHARE, why)


def without_gyro(model: float | None, zero: float, hold: float, words: AxisWords) -> Use:
    """The verdict by errors of free runs on unseen data [rad/s]: of the model, of no motion, of the first rate kept."""
    use, least = use_without_gyro(words), min(zero, hold)
    if model is None or least <= 0.0:
        return Use(use, math.inf, MAX_MOTION_SHARE, "the simulated motion runs away")
    share = model / least
    scale, unit = (math.degrees(1.0), "°") if words.rate_unit == "rad/s" else (1.0, " m")
    turned, without = (f"{float(f'{AHEAD_S * scale * each:.2g}'):g}{unit}" for each in (model, least))
    why = (
        f"{_percent(share)} of the error without a model (at most {_percent(MAX_MOTION_SHARE)}), "
        f"up to {turned} RMS after {AHEAD_S:g} s, not {without}"
    )
    return Use(use, share, MAX_MOTION_SHARE, why)


def use_without_gyro(words: AxisWords) -> str:
    if words.rate_unit == "rad/s":
        return f"{'heading' if words.name == 'yaw' else words.name} without a gyro"
    return f"{words.name} position without a velocity sensor"


def noticing(share: float, what: str) -> Use:
    """The verdict by the smallest change that shows, as a share of `what` changes."""
    why = f"a change of {_percent(share)} in the {what} shows (at most {_percent(MAX_CHANGE_SHARE)})"
    return Use("noticing a change", share, MAX_CHANGE_SHARE, why)


def closed_loop(use: str, words: AxisWords) -> Use:
    return unknown(
        use,
        MAX_MOTION_SHARE,
        f"the {words.effort} answers the {words.rate}, so a free run proves nothing; log open loop",
    )


def compared_words(model: float | None, zero: float, hold: float, words: AxisWords) -> str:
    """The free run's error beside those without a model, and what this says."""
    if model is None:
        return f"the simulated motion runs away (no motion at all errs by {zero:.4g} {words.rate_unit})"
    without = f"where no motion at all gives {zero:.4g} and the first {words.rate} kept {hold:.4g}"
    beside = f"{model:.4g} {words.rate_unit}, {without}"
    least = min(zero, hold)
    if model >= least:
        return f"{beside}: nothing useful was learned"
    if model > LITTLE_SHARE * least:
        return f"{beside}: hardly anything was learned"
    return f"{beside}: {_percent(model / least)} of the smaller one"


def good_enough_lines(uses: Iterable[Use]) -> list[str]:
    """The verdicts for people."""
    return ["Good enough?", *(f"  {use.use}? {use.verdict}: {use.why}" for use in uses)]


def good_enough(uses: Iterable[Use]) -> Mapping[str, Any]:
    """The verdicts for programs: use → verdict."""
    return {use.use.replace(" ", "_").replace("-", "_"): use.to_dict() for use in uses}


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share < 0.1 else f"{100.0 * share:.0f} %" if math.isfinite(share) else "all"
