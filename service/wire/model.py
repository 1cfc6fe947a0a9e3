"""The served model, the messages of an iteration and of their history, and the ledger of traced effects."""

from __future__ import annotations

import math
import operator
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from incsvr.learning.excitation import Water
from incsvr.learning.model import Model
from incsvr.learning.several_velocities.several import Several
from incsvr.learning.spread import Spread
from incsvr.plant.mass_and_coriolis import inertia_in_force
from service.wire.form import Form, Numbers, WithNoise


class Points(Form):
    """Samples: yaw rate [rad/s] and damping [N m], of equal length; where damping is learned over several velocities
    the others as well, by their names."""

    rate: Numbers = ()
    damping: Numbers = ()
    others: dict[str, Numbers] = Field(default={}, exclude_if=operator.not_)

    @model_validator(mode="after")
    def _equal_length(self) -> Self:
        if len(self.rate) != len(self.damping):
            raise ValueError(f"rate has {len(self.rate)} and damping {len(self.damping)} values")
        for name, values in self.others.items():
            if len(values) != len(self.rate):
                raise ValueError(f"rate has {len(self.rate)} and {name} {len(values)} values")
        return self

    def __len__(self) -> int:
        return len(self.rate)


class Support(Points):
    """Support vectors with their weights αⱼ − βⱼ [N m]: f(r) = Σ weightⱼ κ(rateⱼ, r)."""

    weight: Numbers = ()
    count: Numbers = ()  # how many samples each stands for


class Kernel(Form):
    """κ(x, z) = exp(−γ(x − z)²), γ in s²/rad²."""

    name: Literal["rbf"] = "rbf"
    gamma: float


class OverSeveral(Form):
    """The fields of a model over several velocities beside its vectors.

    With uᵢ = νᵢ/fastestᵢ and κ over u times the first of `fastest`, d(ν) = Σ dragⱼ φⱼ(u) + Σ weightⱼ κ₀(νⱼ, ν), where
    κ₀(x, z) = κ(x, z) − κ(x, 0) κ(0, z), φ are the terms of docs/learner.md, and of the further velocities
    none counts as faster than the fastest vector.
    """

    inputs: tuple[str, ...]  # the own velocity first
    fastest: Numbers  # of each, in its unit
    drag: Numbers  # N m
    trained_ranges: dict[str, tuple[float, float]]  # of each further one


class ModelSnapshot(WithNoise):
    """`…/model`: the served model after an iteration. `t` is the vehicle's time of the newest sample in it [s]."""

    boot: str  # another one for each start of the learner
    revision: int  # counts snapshots, over restarts
    iteration: int
    t: float
    kernel: Kernel
    epsilon: float  # N m
    C: float  # N m
    support: Support
    inertia: float  # kg m², dry and added
    effects: tuple[dict[str, Any], ...] = ()  # the promoted effects, as in the ledger
    trained_range: tuple[float, float] | None = None  # rad/s; beyond it the model extrapolates
    certified_error: float | None = None  # N m, bound of sup |f − f*|
    correlation: float = 0.0  # of the noise of two samples that follow each other
    water: Water = Water()  # the motion that was no evidence about damping
    spread: Spread = Spread(1.0)  # the noise's variance as a share of noise², at rates evenly from 0 to the fastest
    widening: float = 1.0  # of the curve's own doubt, since fresh samples disagreed
    over: OverSeveral | None = Field(default=None, exclude_if=lambda over: over is None)

    @property
    def inertia_in_force(self) -> float:
        """The inertia that the model goes by: the traced one where that is among its effects [kg m²]."""
        return inertia_in_force(self.inertia, self.effects)

    def model(self) -> Model:
        """The model to predict with: damping, its uncertainty, and where it extrapolates."""
        support = self.support
        return Model(
            gamma=self.kernel.gamma,
            C=self.C,
            epsilon=self.epsilon,
            support_rate=np.array(support.rate),
            support_damping=np.array(support.damping),
            weight=np.array(support.weight),
            count=np.array(support.count) if support.count else np.ones(len(support)),
            sigma=math.nan if self.noise is None else self.noise,
            certified_error=self.certified_error or 0.0,
            correlation=self.correlation,
            water=self.water,
            spread=self.spread,
            widening=self.widening,
            several=self._several(),
        )

    def _several(self) -> Several | None:
        if self.over is None:
            return None
        own, *others = self.over.inputs
        velocity = np.column_stack([self.support.rate, *(self.support.others[name] for name in others)])
        return Several(own, tuple(others), velocity, np.array(self.over.fastest), np.array(self.over.drag))


class Coefficient(Form):
    """A coefficient and its interval of 95 %: N_r [N m s/rad], N_{r|r|} [N m s²/rad²]; positive where it opposes."""

    estimate: float
    low: float
    high: float


class Coefficients(Form):
    """`…/coefficients`: the best N_r r + N_{r|r|} r|r| of the served model, for who draws no curve."""

    boot: str
    revision: int
    iteration: int
    t: float  # the vehicle's time of the newest sample [s]
    coefficients: dict[str, Coefficient]  # "N_r", "N_r|r|"
    trained_range: tuple[float, float] | None  # rad/s


SETS = ("old", "new", "support", "forgotten", "discarded_tube", "discarded_near", "outliers")
"""The sets of points of one iteration (Fig. 5-6), in the order in which they are drawn."""


class Validation(Form):
    """The served model's error on data that it never learned from (Fig. 7)."""

    name: str
    mae: float  # N m
    rmse: float  # N m
    samples: int
    untrained: float | None = None  # MAE of a model that has learned nothing, d = 0 [N m]


class Batch(Form):
    """The synchronised samples of the iteration in the order of their time, and what the model said before it saw them.

    `predicted` is None before anything was learned; damping − predicted is the residual [N m]. A channel is None where
    it was not sampled. Where traced effects are in force, `parts` says what the declared inertia and each effect take
    of the torque: predicted + Σ parts is the torque that the model predicts, damping + Σ parts the measured one.
    """

    time: Numbers = ()  # the vehicle's time [s]
    rate: Numbers = ()  # rad/s
    damping: Numbers = ()  # N m
    predicted: Numbers | None = None  # N m
    channels: dict[str, tuple[float | None, ...]] = Field(default_factory=dict)
    parts: dict[str, Numbers] = Field(default_factory=dict)  # N m


class IterationReport(WithNoise):
    """`…/iteration`: all that Fig. 5-6 draw, and what a table of the iteration holds.

    `old` are the support vectors before it, `new` the samples that passed the inclusion criterion, `support` those
    served now, `forgotten` what the forgetting criterion deleted, `discarded_tube` and `discarded_near` what inclusion
    turned away (|f − y| < ε; too near a support vector), `outliers` what went after training.
    """

    boot: str
    revision: int
    iteration: int
    t: float  # the vehicle's time of the newest sample [s]
    time_span: tuple[float, float]  # of the batch, the vehicle's time [s]
    trained: bool  # False where the whole batch was discarded
    training_ms: float
    counts: dict[str, int]  # size of every set of SETS, "batch", and "undriven": no evidence about damping
    old: Points
    new: Points
    support: Points
    forgotten: Points
    discarded_tube: Points
    discarded_near: Points
    outliers: Points
    batch: Batch = Batch()
    certified_error: float | None = None  # N m
    progressive_mae: float | None = None  # MAE on the batch before it was learned [N m]
    validation: tuple[Validation, ...] = ()  # where validation data is configured
    learned: float = 0.0
    change: str | None = None  # what the learner noticed about the vehicle, in words


class IterationHistory(Form):
    """The answer to `…/iteration?after=REVISION;limit=N`: reports in the order of their revision."""

    iterations: tuple[IterationReport, ...]
    latest_revision: int  # ask again with the last report's revision until it is this


class EffectsLedger(Form):
    """`…/effects`: the traced effects that the served model holds, what was found beside them, and every step.

    An effect has the form of CONTRACT, Section 5; it is carried as it is. What was found and is not in force says
    besides whether it is "suspected" or "proven" (`state`), on which data (`since`, `until` [s]) and, once it has been
    compared on fresh data, how large the errors of torque and free run are there (`error`). The answer to a get holds
    the newest batch, whose `parts` are the torque ledger.
    """

    mode: Literal["off", "advise", "adopt"] = "off"  # of live tracing
    work: Literal["trace", "prove"] | None = None  # what the process beside the learner does now
    effects: tuple[dict[str, Any], ...] = ()
    found: tuple[dict[str, Any], ...] = ()
    history: tuple[dict[str, Any], ...] = ()
    batch: Batch | None = None
