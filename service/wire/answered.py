"""Questions about damping, and the answers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from service.wire.form import Form, Numbers


class DampingReply(Form):
    """`…/damping`: the model at the asked rates, in their order."""

    rate: Numbers  # rad/s
    damping: Numbers  # N m
    sigma: Numbers  # N m, one standard deviation of a sample there
    extrapolated: tuple[bool, ...]
    iteration: int
    revision: int


class ErrorReply(Form):
    """The error reply to a query."""

    error: str
    error_type: str


class DampingQuery(Form):
    """The payload of a damping query, in place of the parameter `rate`."""

    rate: Annotated[Numbers, Field(min_length=1)]
