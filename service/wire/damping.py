"""Questions about damping, and the answers."""

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
