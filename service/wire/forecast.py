"""The model in the gyro's place: what is asked, answered, and said while the yaw rate is silent or not believed."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from service.wire.form import Form, Numbers


class ForecastQuery(Form):
    """The payload of a forecast query: a torque that somebody plans, from the last measurement on."""

    t: Annotated[Numbers, Field(min_length=1, max_length=5_000)]  # s since the last measurement, not decreasing
    torque: Annotated[Numbers, Field(min_length=1, max_length=5_000)]  # N m, on a line between two, held after the last
    at: Annotated[Numbers, Field(min_length=1, max_length=5_000)] | None = None  # s, where answers are wanted; None: t


class ForecastReply(Form):
    """`…/forecast`: where yaw rate and heading go, each with an interval of 95 %."""

    since: float  # the vehicle's time of the last measurement [s]
    measured: float  # the yaw rate then [rad/s]
    t: Numbers  # the vehicle's time [s]
    rate: Numbers  # rad/s
    rate_low: Numbers
    rate_high: Numbers
    turned: Numbers  # the heading's change since then [rad]
    turned_low: Numbers
    turned_high: Numbers
    worth: tuple[bool, ...]  # whether the rate's interval is narrower than what the rates are usually within
    iteration: int
    revision: int


class Estimate(Form):
    """`…/estimate`: the yaw rate by the model alone, while the gyro is silent or not believed."""

    t: float  # the vehicle's time [s]
    rate: float  # rad/s
    rate_low: float
    rate_high: float
    turned: float  # the heading's change since the last measurement [rad]
    turned_low: float
    turned_high: float
    since: float  # the vehicle's time of the last measurement [s]
    age_s: float  # how long ago that was [s]
    worth: bool  # false where whoever knows nothing but the vehicle's usual rates knows as much
    why: str  # why it is the model's own, and what is left of it
    iteration: int
    revision: int
