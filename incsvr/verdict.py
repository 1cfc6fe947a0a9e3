"""What becomes of effects, given how the model did with and without them on data that nobody had looked at.

Effects on trial must make the free run better beyond chance; those in force go when they make it worse beyond chance,
or twice running no better.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["promoted", "refused", "kept", "doubted", "withdrawn", "waits"]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Free runs of two models on the same fresh data (`incsvr.shadow.compare`).

    Attributes:
        without: root mean square of the error without the effects [rad/s].
        estimate: change of it by the effects [rad/s].
        low, high: the change's 95 % interval [rad/s].
        turned: whether the vehicle moved enough to tell.
    """

    without: float
    estimate: float
    low: float
    high: float
    turned: bool

    @property
    def sentence(self) -> str:
        """For people."""
        if not self.turned:
            return "the vehicle hardly turned on the fresh data, which tells nothing"
        return (
            f"free run on fresh data: {self.without:.3g} rad/s without, {self.without + self.estimate:.3g} rad/s with "
            f"it ({self.low:+.3g} to {self.high:+.3g})"
        )


def on_trial(found: Comparison) -> Verdict:
    """What becomes of effects in shadow."""
    if not found.turned:
        return "waits"
    return "promoted" if found.high < 0.0 else "refused"


def in_force(found: Comparison, doubted: bool) -> Verdict:
    """What becomes of effects in force; `doubted` says that they brought nothing the last time, too."""
    if not found.turned:
        return "waits"
    if found.low > 0.0:
        return "withdrawn"
    if found.estimate < 0.0:
        return "kept"
    return "withdrawn" if doubted else "doubted"
