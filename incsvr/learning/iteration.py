"""The settings of an iteration of the learner (`Settings`) and its result (`Iteration`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.signals.samples import Samples

_NONE = Samples.empty()
PAPER_RATE, PAPER_TORQUE = 0.25, 100.0
"""The range for which the paper's settings were tuned [rad/s], [N m]."""


@dataclass(frozen=True, slots=True)
class Settings:
    """The settings of the learner. The numbers are the paper's: γ, C, ε as tuned in Section IV-B, the rest from III-C.

    The policy is not: "weighted" (weighted.py) averages noise, and comes nearer to the truth in every scenario
    of `python -m benchmarks.paper`.
    """

    gamma: float = 10.0  # kernel width γ [(rad/s)⁻²]
    C: float = 1000.0  # bound on a vector's weight [N m]
    epsilon: float = 0.1  # half height of the tube [N m]
    capacity: int = 60  # how many support vectors may be served and carried into the next iteration
    batch: int = 50  # samples of one iteration
    near_rate: float = 0.01  # a [rad/s], b [N m] of the inclusion
    near_damping: float = 5.0
    bins: int = 20  # equal bins over `rate_range` for the forgetting (the paper does not give their number)
    rate_range: tuple[float, float] = (-0.25, 0.25)  # the vehicle's lowest and highest yaw rate [rad/s]
    # which samples are kept, "paper" (over one velocity) or "weighted"
    policy: Literal["paper", "weighted"] = "weighted"
    solver: Literal["exact", "passes"] = "exact"  # "exact", or "passes" of Eq. 8 with a warm start
    own: str = "yaw_rate"  # the axis's own velocity, as recordings call it
    # further velocities that damping is learned over, channels of the samples; none by default
    others: tuple[str, ...] = ()
    # of each of them, by which it is scaled, in its unit; those left out follow what was driven
    fastest: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("gamma", "C", "capacity", "batch", "near_rate", "near_damping", "bins"):
            if not getattr(self, name) > 0:
                raise BadInput(f"the learner's {name} is {getattr(self, name)}; give a number above 0")
        if not self.epsilon >= 0:
            raise BadInput(f"the learner's epsilon is {self.epsilon}; give 0 or more [N m]")
        low, high = self.rate_range
        if not low < high:
            raise BadInput(f"the learner's rate_range is [{low}, {high}] rad/s; give the lower end first")
        if self.policy not in ("paper", "weighted"):
            raise BadInput(f'the learner has no policy "{self.policy}"; choose "paper" or "weighted"')
        if self.policy == "paper" and self.others:
            raise BadInput("the policy paper is for one velocity; take weighted, or leave the further velocities out")
        if self.solver not in ("exact", "passes"):
            raise BadInput(f'the learner has no solver "{self.solver}"; choose "exact" or "passes"')


def scaled_to(fastest: float, damping: float, /, **chosen: object) -> Settings:
    """The paper's settings, where lengths in velocity and in damping are scaled to what the vehicle reaches.

    Args:
        fastest: the largest velocity [rad/s], [m/s].
        damping: the largest damping [N m], [N].
        chosen: settings that are not scaled.
    """
    rate, torque, paper = fastest / PAPER_RATE, damping / PAPER_TORQUE, Settings()
    scaled = {
        "gamma": paper.gamma / rate**2,
        "C": paper.C * torque,
        "epsilon": paper.epsilon * torque,
        "near_rate": paper.near_rate * rate,
        "near_damping": paper.near_damping * torque,
        "rate_range": (paper.rate_range[0] * rate, paper.rate_range[1] * rate),
    }
    return Settings(**{**scaled, **chosen})  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Iteration:
    """One iteration of Fig. 3 and all that Fig. 5–6 draw of it."""

    number: int  # counts from 1
    trained: bool  # False where nothing of the batch was learned: then the model is the one before
    model: Model  # what is served from now on
    old: Samples  # vectors kept from before that were trained on
    support: Samples  # the vectors of the served model
    new: Samples = _NONE  # samples of the batch that were trained on
    forgotten: Samples = _NONE  # vectors that the forgetting took away
    discarded_tube: Samples = _NONE  # samples of the batch that told nothing new: inside the tube, beside a vector
    discarded_near: Samples = _NONE
    outliers: Samples = _NONE  # what the outlier criterion took away
    # samples of the batch that are no evidence about damping, because the torque did not make their motion
    undriven: Samples = _NONE
    time_span: tuple[float, float] = (0.0, 0.0)  # time of the batch's first and last sample [s]
    # mean error of the batch under the curve that was served before it [N m]; None before one was
    progressive_mae: float | None = None
    change: str | None = None  # a sentence when the policy noticed that the vehicle has changed, or took that back
