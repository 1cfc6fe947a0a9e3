"""The decision on effects, by the errors with and without them on data that came after their trace.

Suspected effects must predict better beyond chance; those in force are withdrawn when they predict worse beyond chance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from incsvr.plant.words import YAW_WORDS, AxisWords

Verdict = Literal["promoted", "proven", "refused", "kept", "doubted", "withdrawn", "waits"]


@dataclass(frozen=True, slots=True)
class Proof:
    """A comparison of two models on the same fresh data (`incsvr.compensation.fresh_data.compare_on_fresh_data`).

    Attributes:
        error: before, after and change as `incsvr trace --json` has them; None for a number that there is not.
        closed: whether the predicted torque decides, else the free run.
        better: whether the effects are proven, as `incsvr trace` proves them on recordings for validation.
        turned: whether the vehicle moved enough to tell.
    """

    error: Mapping[str, Any]
    closed: bool
    better: bool
    turned: bool

    @property
    def worse(self) -> bool:
        """Whether the error that decides rose beyond chance."""
        low = self.error["change"]["torque_rmse" if self.closed else "free_run_rmse"]["low"]
        return low is not None and low > 0.0

    def of_suspected(self, last: bool) -> Verdict:
        """The decision on suspected effects; unless this is the last look, more data may prove them."""
        if self.turned and self.better:
            return "promoted"
        return "refused" if last or (self.turned and self.worse) else "waits"

    def of_known(self) -> Verdict:
        """The decision on effects in force or proven."""
        return "withdrawn" if self.turned and self.worse else "kept"

    def sentence(self, words: AxisWords = YAW_WORDS) -> str:
        """The sentence for people: what decides, then both errors."""
        decides = f"the error of the predicted {words.effort}" if self.closed else "the error of the free run"
        judged = "is lower" if self.better else "is higher" if self.worse else "is not proven lower"
        return f"on data after the trace {decides} {judged}: {errors(self.error, words)}"


def errors(error: Mapping[str, Any], words: AxisWords = YAW_WORDS) -> str:
    """The errors before and after, of the form of `Comparison.error`, for people; None in JSON is no number."""
    return f"{words.effort} {_change(error, 'torque_rmse')} {words.effort_unit}, {_free_run(error, words)}"


def _change(error: Mapping[str, Any], key: str) -> str:
    return " → ".join("–" if error[when][key] is None else f"{error[when][key]:.3g}" for when in ("before", "after"))


def _free_run(error: Mapping[str, Any], words: AxisWords) -> str:
    """The free run's errors; where they prove no change, the interval of it alone."""
    change = error.get("change", {}).get("free_run_rmse", {})
    low, high = (math.nan if change.get(end) is None else change[end] for end in ("low", "high"))
    if low <= 0.0 <= high:
        return f"free runs do not differ provably ({low:+.3g} to {high:+.3g} {words.rate_unit})"
    worse = "but free runs err more: " if low > 0.0 else "free run "
    return f"{worse}{_change(error, 'free_run_rmse')} {words.rate_unit}"
