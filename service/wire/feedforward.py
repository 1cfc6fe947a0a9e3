"""The torque that drives a planned yaw rate: what is asked, and the answer."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from service.wire.form import Form, Numbers

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
