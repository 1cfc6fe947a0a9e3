"""The messages of an iteration, of the history of iterations, and of the ledger of traced effects."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from service.wire.form import Form, Numbers, WithNoise
from service.wire.model import Points

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
