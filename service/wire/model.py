"""The served model, the messages of an iteration and of their history, and the ledger of traced effects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from incsvr.learning.drag import Several
from incsvr.learning.excitation import Water
from incsvr.learning.model import Model
from incsvr.learning.noise import Spread
from incsvr.numerics.plain import UNLESS_EMPTY, from_plain, to_plain
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.signals.samples import Samples
from service.wire.form import Form, Numbers, WithNoise


@dataclass(frozen=True)
class Points(Form):
    """Samples: yaw rate [rad/s] and damping [N m], of equal length; where damping is learned over several velocities
    the others as well, by their names."""

    rate: Numbers = ()
    damping: Numbers = ()
    others: dict[str, Numbers] = field(default_factory=dict, metadata=UNLESS_EMPTY)

    def __post_init__(self) -> None:
        for name, values in (("damping", self.damping), *self.others.items()):
            if len(values) != len(self.rate):
                raise ValueError(f"rate has {len(self.rate)} and {name} {len(values)} values")

    @staticmethod
    def of(samples: Samples) -> Points:
        """The points of samples."""
        others = {name: tuple(values.tolist()) for name, values in samples.channels.items()}
        return Points(tuple(samples.yaw_rate.tolist()), tuple(samples.damping.tolist()), others)

    def __len__(self) -> int:
        return len(self.rate)


@dataclass(frozen=True)
class Vectors(Points):
    """Support vectors with their weights αⱼ − βⱼ [N m]: f(r) = Σ weightⱼ κ(rateⱼ, r)."""

    weight: Numbers = ()
    count: Numbers = ()  # how many samples each stands for; none of an older learner, each for one


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelSnapshot(Form):
    """The model that is served after an iteration, replaced as a whole; `…/model` is its `to_dict`.

    In the payload κ(x, z) = exp(−γ(x − z)²) is `kernel`, with γ in s²/rad², and the vectors are `support`. A model over
    several velocities has the field `over` besides: with uᵢ = νᵢ/fastestᵢ and κ over u times the first of `fastest`,
    d(ν) = Σ dragⱼ φⱼ(u) + Σ weightⱼ κ₀(νⱼ, ν), where κ₀(x, z) = κ(x, z) − κ(x, 0) κ(0, z), φ are the terms of
    docs/learner.md, and of the further velocities none counts as faster than the fastest vector.
    """

    boot: str = ""  # another one for each start of the learner
    revision: int  # counts snapshots, over restarts
    iteration: int
    t: float | None  # the vehicle's time of the newest sample in it [s]; None before the first
    model: Model
    inertia: float  # kg m², dry and added
    effects: tuple[dict[str, Any], ...] = ()  # the promoted effects, as in the ledger

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ModelSnapshot) and self.to_dict() == other.to_dict()

    @property
    def inertia_in_force(self) -> float:
        """The inertia that the model goes by: the traced one where that is among its effects [kg m²]."""
        return inertia_in_force(self.inertia, self.effects)

    @property
    def noise(self) -> float | None:
        """The samples' own deviation, over all rates [N m]; None where nothing is learned."""
        return self.model.sigma if math.isfinite(self.model.sigma) else None

    @property
    def support(self) -> Vectors:
        """The support vectors."""
        model = self.model
        others = {name: tuple(values.tolist()) for name, values in model.others_at_support.items()}
        columns = (model.support_rate, model.support_damping, model.weight, model.count)
        rate, damping, weight, count = (tuple(column.tolist()) for column in columns)
        return Vectors(rate, damping, others, weight, count)

    def to_dict(self) -> dict[str, Any]:
        """The payload."""
        model, several = self.model, self.model.several
        told = {
            "noise": self.noise,
            "sigma": self.noise,  # its copy for one release
            "boot": self.boot,
            "revision": self.revision,
            "iteration": self.iteration,
            "t": self.t or 0.0,
            "kernel": {"name": "rbf", "gamma": model.gamma},
            "epsilon": model.epsilon,
            "C": model.C,
            "support": to_plain(self.support),
            "inertia": self.inertia,
            "effects": to_plain(self.effects),
            "trained_range": to_plain(model.trained_range),
            "certified_error": model.certified_error if model.is_trained else None,
            "correlation": model.correlation,
            "water": to_plain(model.water),
            "spread": to_plain(model.spread),
        }
        if several is not None:
            told["over"] = {
                "inputs": [several.own, *several.others],
                "fastest": several.fastest.tolist(),
                "drag": several.drag.tolist(),
                "trained_ranges": to_plain(several.ranges),
            }
        return told

    @staticmethod
    def from_dict(told: Mapping[str, Any]) -> ModelSnapshot:
        """The snapshot of a payload; an earlier learner says less.

        Raises:
            Exception: of any kind, where it is none.
        """
        vectors, noise = from_plain(Vectors, told["support"]), told.get("noise", told.get("sigma"))
        rate = np.array(vectors.rate)
        several = None
        if (over := told.get("over")) is not None:
            own, *others = over["inputs"]
            velocity = np.column_stack([rate, *(vectors.others[name] for name in others)])
            several = Several(own, tuple(others), velocity, np.array(over["fastest"]), np.array(over["drag"]))
        model = Model(
            gamma=float(told["kernel"]["gamma"]),
            C=float(told["C"]),
            epsilon=float(told["epsilon"]),
            support_rate=rate,
            support_damping=np.array(vectors.damping),
            weight=np.array(vectors.weight),
            count=np.array(vectors.count) if vectors.count else np.ones(len(vectors)),
            sigma=math.nan if noise is None else float(noise),
            certified_error=told.get("certified_error") or 0.0,
            correlation=told.get("correlation", 0.0),
            water=from_plain(Water, told.get("water", {})),
            spread=from_plain(Spread, told.get("spread", {"fastest": 1.0})),
            several=several,
        )
        return ModelSnapshot(
            boot=told["boot"],
            revision=told["revision"],
            iteration=told["iteration"],
            t=float(told["t"]),
            model=model,
            inertia=float(told["inertia"]),
            effects=tuple(told.get("effects", ())),
        )


@dataclass(frozen=True)
class Coefficient(Form):
    """A coefficient and its interval of 95 %: N_r [N m s/rad], N_{r|r|} [N m s²/rad²]; positive where it opposes."""

    estimate: float
    low: float
    high: float


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class Validation(Form):
    """The served model's error on data that it never learned from (Fig. 7)."""

    name: str
    mae: float  # N m
    rmse: float  # N m
    samples: int
    untrained: float | None = None  # MAE of a model that has learned nothing, d = 0 [N m]


@dataclass(frozen=True)
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
    channels: dict[str, tuple[float | None, ...]] = field(default_factory=dict)
    parts: dict[str, Numbers] = field(default_factory=dict)  # N m


@dataclass(frozen=True, kw_only=True)
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


@dataclass(frozen=True)
class IterationHistory(Form):
    """The answer to `…/iteration?after=REVISION;limit=N`: reports in the order of their revision."""

    iterations: tuple[IterationReport, ...]
    latest_revision: int  # ask again with the last report's revision until it is this


@dataclass(frozen=True)
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
