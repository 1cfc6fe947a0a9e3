"""A fault that begins or ends, as it is published once."""

from __future__ import annotations

from typing import Literal

from service.wire.form import Form


class ThrustEvent(Form):
    """`…/event`: thrust is lost, or back, with the model that holds from then on: I ṙ + d(r) = `thrust` τ, d(r) as the
    `revision` has it."""

    boot: str
    event: Literal["thrust lost", "thrust back"]
    axis: str  # such as yaw
    since: float  # its onset, the vehicle's time [s]
    t: float  # the end of the data that showed it [s]
    size: float  # part of the usual thrust that is lacking; about 0 where it is back
    size_low: float  # interval of 95 %
    size_high: float
    thrust: float  # part of the usual thrust that there is
    inertia: float  # kg m²
    revision: int | None  # of the model that was served at the onset; None where no history reaches so far back
    cannot_tell_from: tuple[str, ...]  # of "damping", "moment", "inertia"
    why: str  # a sentence for people
