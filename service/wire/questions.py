"""The questions to a learner (damping, feed-forward, forecast) and the answers, as the estimate in the gyro's place."""

from __future__ import annotations

import operator
from typing import Annotated

from pydantic import Field

from service.wire.form import Form, Numbers


class DampingReply(Form):
    """`…/damping`: the model at the asked rates, in their order."""

    rate: Numbers  # rad/s
    damping: Numbers  # N m
    sigma: Numbers  # N m, standard deviation of one sample about the curve
    extrapolated: tuple[bool, ...]
    iteration: int
    revision: int
    doubt: Numbers = ()  # N m, standard deviation of the curve; none of an older learner
    derivative: Numbers = ()  # N m s/rad, of the damping by the axis's own velocity; none of an older learner
    others: dict[str, Numbers] = Field(default={}, exclude_if=operator.not_)  # the further velocities, as asked


class ErrorReply(Form):
    """The error reply to a query."""

    error: str
    error_type: str


class DampingQuery(Form):
    """The payload of a damping query, in place of the parameters: the own velocity, and others by their names."""

    rate: Annotated[Numbers, Field(min_length=1)]
    others: dict[str, Annotated[Numbers, Field(min_length=1)]] = Field(default={})


Profile = Annotated[Numbers, Field(min_length=1, max_length=5_000)]
"""Values of a plan."""


class FeedforwardQuery(Form):
    """The payload of a feed-forward query: a planned motion, linear between two times."""

    t: Profile  # s from any origin, increasing
    rate: Profile  # rad/s
    acceleration: Profile | None = None  # rad/s²; None: the slope of the rate
    channels: dict[str, Profile] = Field(default={})  # further channels that effects, damping or the body read


class FeedforwardReply(Form):
    """`…/feedforward`: the torque that drives the plan, with an interval of 95 %; its parts add up to it."""

    t: Numbers  # s, as asked
    torque: Numbers  # N m
    low: Numbers
    high: Numbers
    inertia_part: Numbers  # of the declared inertia
    body_part: Numbers  # of the body's other velocities and its attitude
    damping_part: Numbers  # of the learned damping
    effects_part: Numbers  # of all effects in force
    effects: dict[str, Numbers]  # of each of them
    lead_s: float  # send the torque so much earlier than t
    told: tuple[str, ...]  # sentences about what the torque cannot do
    iteration: int
    revision: int


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
