"""What becomes of effects, given how the model did with and without them on data that nobody had looked at.

Effects on trial must make the free run better beyond chance; those in force go when they make it worse beyond chance,
or twice running no better.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Verdict = Literal["promoted", "proven", "refused", "kept", "doubted", "withdrawn", "waits"]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Free runs of two models on the same fresh data (`incsvr.shadow.compare`).

    Attributes:
        without: root mean square of the error without the effects [rad/s].
        estimate: change of it by the effects [rad/s].
        low, high: the change's 95 % interval [rad/s].
        turned: whether the vehicle moved enough to tell.
        torque_without, torque_with: root mean square of the torque's error on the samples of the same data [N m].
    """

    without: float
    estimate: float
    low: float
    high: float
    turned: bool
    torque_without: float
    torque_with: float

    @property
    def error(self) -> dict[str, Any]:
        """Before and after, in the form of CONTRACT, Section 5."""
        return {
            "before": {"torque_rmse": self.torque_without, "free_run_rmse": self.without},
            "after": {"torque_rmse": self.torque_with, "free_run_rmse": self.without + self.estimate},
            "change": {"free_run_rmse": {"estimate": self.estimate, "low": self.low, "high": self.high}},
        }

    @property
    def sentence(self) -> str:
        """For people."""
        if not self.turned:
            return "the vehicle hardly turned on the fresh data, which tells nothing"
        return (
            f"free run on fresh data: {self.without:.3g} rad/s without, {self.without + self.estimate:.3g} rad/s with "
            f"it ({self.low:+.3g} to {self.high:+.3g})"
        )


def on_trial(found: Comparison, last: bool = True) -> Verdict:
    """What becomes of suspected effects; unless this is the last look, those that seem to pay may prove it on more.

    The interval excludes zero by chance once in forty looks. The looks share their data: two or three of them are less
    than two or three in forty.
    """
    if not found.turned:
        return "waits"
    if found.high < 0.0:
        return "promoted"
    return "waits" if found.estimate < 0.0 and not last else "refused"


def in_force(found: Comparison, doubted: bool) -> Verdict:
    """What becomes of effects in force; `doubted` says that they brought nothing the last time, too."""
    if not found.turned:
        return "waits"
    if found.low > 0.0:
        return "withdrawn"
    if found.estimate < 0.0:
        return "kept"
    return "withdrawn" if doubted else "doubted"


def errors(error: Mapping[str, Any]) -> str:
    """The errors before and after, of the form of `Comparison.error`, for people."""
    before, after = error["before"], error["after"]
    return (
        f"torque {before['torque_rmse']:.3g} → {after['torque_rmse']:.3g} N m, "
        f"free run {before['free_run_rmse']:.3g} → {after['free_run_rmse']:.3g} rad/s"
    )
