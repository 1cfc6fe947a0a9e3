"""The questions to a learner (damping, feed-forward, forecast) and the answers, as the estimate in the gyro's place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from incsvr.numerics.plain import UNLESS_EMPTY
from service.wire.form import Form, Numbers


@dataclass(frozen=True, kw_only=True)
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
    # the further velocities, as asked
    others: Mapping[str, Numbers] = field(default_factory=dict, metadata=UNLESS_EMPTY)


@dataclass(frozen=True, kw_only=True)
class ErrorReply(Form):
    """The error reply to a query."""

    error: str
    error_type: str


@dataclass(frozen=True)
class DampingQuery(Form):
    """The payload of a damping query, in place of the parameters: the own velocity, and others by their names."""

    rate: Numbers
    others: Mapping[str, Numbers] = field(default_factory=dict)  # each of so many values, or a single one for all

    def __post_init__(self) -> None:
        for name, values in (("rate", self.rate), *self.others.items()):
            if not values:
                raise ValueError(f"{name}: give one value at least")


MAX_PLAN_VALUES = 5_000
"""Values of a plan."""


def _check_plan(profiles: Mapping[str, Numbers | None]) -> None:
    for name, values in profiles.items():
        if values is not None and not 1 <= len(values) <= MAX_PLAN_VALUES:
            raise ValueError(f"{name}: give 1 to {MAX_PLAN_VALUES} values, not {len(values)}")


@dataclass(frozen=True, kw_only=True)
class FeedforwardQuery(Form):
    """The payload of a feed-forward query: a planned motion, linear between two times."""

    t: Numbers  # s from any origin, increasing
    rate: Numbers  # rad/s
    acceleration: Numbers | None = None  # rad/s²; None: the slope of the rate
    channels: Mapping[str, Numbers] = field(default_factory=dict)  # further ones that effects, damping, the body read

    def __post_init__(self) -> None:
        _check_plan({**self.channels, "t": self.t, "rate": self.rate, "acceleration": self.acceleration})


@dataclass(frozen=True, kw_only=True)
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


@dataclass(frozen=True, kw_only=True)
class ForecastQuery(Form):
    """The payload of a forecast query: a torque that somebody plans, from the last measurement on."""

    t: Numbers  # s since the last measurement, not decreasing
    torque: Numbers  # N m, on a line between two, held after the last
    at: Numbers | None = None  # s, where answers are wanted; None: t

    def __post_init__(self) -> None:
        _check_plan({"t": self.t, "torque": self.torque, "at": self.at})


@dataclass(frozen=True, kw_only=True)
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


@dataclass(frozen=True, kw_only=True)
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
