"""The keys and messages of the bus, by CONTRACT, Section 2.

Everybody who speaks with the learner imports this package: the learner itself, the player, the viewer, the demo. A form
is a frozen dataclass; `encode` gives the UTF-8 JSON bytes that are put, `decode` reads them or raises `BadInput`.
Readers ignore fields that they do not know, so that a newer learner may say more.

Besides the contract's forms: a get on `…/iteration?after=REVISION;limit=N` answers with an `IterationHistory`, so that
a viewer that starts late draws what happened before.
"""

from __future__ import annotations

from service.wire.form import Form, FormType, Numbers, decode, encode
from service.wire.health import Health, Learning, Level, Measurement, Reason, StreamHealth, ThrustEvent, measurement
from service.wire.keys import Keys
from service.wire.model import (
    SETS,
    Batch,
    Coefficient,
    Coefficients,
    EffectsLedger,
    IterationHistory,
    IterationReport,
    ModelSnapshot,
    Points,
    Validation,
)
from service.wire.questions import (
    DampingQuery,
    DampingReply,
    ErrorReply,
    Estimate,
    FeedforwardQuery,
    FeedforwardReply,
    ForecastQuery,
    ForecastReply,
)

__all__ = [
    "SETS",
    "Batch",
    "Coefficient",
    "Coefficients",
    "DampingQuery",
    "DampingReply",
    "EffectsLedger",
    "ErrorReply",
    "Estimate",
    "FeedforwardQuery",
    "FeedforwardReply",
    "ForecastQuery",
    "ForecastReply",
    "Form",
    "FormType",
    "Health",
    "IterationHistory",
    "IterationReport",
    "Keys",
    "Learning",
    "Level",
    "Measurement",
    "ModelSnapshot",
    "Numbers",
    "Points",
    "Reason",
    "StreamHealth",
    "ThrustEvent",
    "Validation",
    "decode",
    "encode",
    "measurement",
]
