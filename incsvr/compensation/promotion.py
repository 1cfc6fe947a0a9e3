"""The decision on effects, by the model's errors with and without them on unseen data.

Effects on trial must predict better beyond chance; those in force are withdrawn when they predict worse beyond chance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from incsvr.plant.words import YAW_WORDS, AxisWords

FALSE_PROOF_CHANCE = 0.05
"""Chance that a learner ever takes an effect for proven which does not foretell better, however long it runs: what the
proof is designed for; its conditions are in bets.py."""
FALSE_REFUSAL_CHANCE = 0.05
"""Chance that an effect is refused early which does foretell better; one that is there is found again."""
FALSE_WITHDRAWAL_CHANCE = 1e-3
"""Chance that a comparison takes an effect out of force which does foretell better."""

Verdict = Literal["promoted", "proven", "refused", "kept", "doubted", "withdrawn", "waits"]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two models on the same fresh data (`incsvr.compensation.fresh_data.compare_on_fresh_data`).

    Attributes:
        without: root mean square of the error without the effects [rad/s].
        estimate: change of it by the effects [rad/s].
        low, high: the change's 95 % interval [rad/s].
        turned: whether the vehicle moved enough to tell.
        torque_without, torque_with: root mean square of the torque's error on the samples of the same data [N m].
        evidence, against: logarithms of the most that bets on the effects, and against them, had won (bets.py).
        won: of what bets on them had won at the end.
    """

    without: float
    estimate: float
    low: float
    high: float
    turned: bool
    torque_without: float
    torque_with: float
    evidence: float
    against: float
    won: float = 0.0

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Comparison:
        """The comparison of its fields as JSON has them: null is no number."""
        known: dict[str, Any] = {name: math.nan if value is None else value for name, value in data.items()}
        return Comparison(**known)

    def after(self, earlier: float) -> Comparison:
        """This comparison, continued from bets that had won e^earlier on other data."""
        return replace(self, evidence=max(self.evidence + earlier, 0.0))

    @property
    def error(self) -> dict[str, Any]:
        """Before and after, in the form of CONTRACT, Section 5."""
        return {
            "before": {"torque_rmse": self.torque_without, "free_run_rmse": self.without},
            "after": {"torque_rmse": self.torque_with, "free_run_rmse": self.without + self.estimate},
            "change": {"free_run_rmse": {"estimate": self.estimate, "low": self.low, "high": self.high}},
        }

    def sentence(self, words: AxisWords = YAW_WORDS, spent: float = FALSE_PROOF_CHANCE) -> str:
        """The sentence for people: what the bets on one-step predictions prove, then the errors of free runs.

        Args:
            spent: chance of a false proof that is spent, which says how much bets must win.
        """
        won, lost = (math.exp(min(each, 50.0)) for each in (self.evidence, self.against))
        if self.evidence >= -math.log(spent):
            verdict = f"its one-step predictions of fresh data are better, by bets won {won:.2g} : 1"
        elif self.against >= -math.log(FALSE_REFUSAL_CHANCE):
            verdict = f"its predictions of fresh data are worse, by bets lost {lost:.2g} : 1"
        else:
            verdict = f"its one-step predictions of fresh data are not proven better: bets won {won:.2g} : 1"
        return f"{verdict}; {_free_run(self.error, words)}"


def level(count: int) -> float:
    """Chance that is spent on what was suspected as the `count`th, from 1: Σ FALSE_PROOF_CHANCE/(k (k + 1)) =
    FALSE_PROOF_CHANCE."""
    return FALSE_PROOF_CHANCE / (count * (count + 1))


def on_trial(found: Comparison, spent: float = FALSE_PROOF_CHANCE, last: bool = True) -> Verdict:
    """The decision on suspected effects; unless this is the last look, they may be proven on more data.

    Args:
        spent: chance that is spent on them, of `level`.
    """
    if not found.turned:
        return "refused" if last else "waits"
    if found.evidence >= -math.log(spent):
        return "promoted"
    return "refused" if last or found.against >= -math.log(FALSE_REFUSAL_CHANCE) else "waits"


def in_force(found: Comparison) -> Verdict:
    """The decision on effects in force or proven."""
    return "withdrawn" if found.turned and found.against >= -math.log(FALSE_WITHDRAWAL_CHANCE) else "kept"


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
