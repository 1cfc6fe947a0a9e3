"""The incoming message: measured values of one stream."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from service.wire.form import Form, Numbers


class Measurement(Form):
    """One measured value, or arrays of equal length, of one stream: the vehicle's time [s] and SI units.

    `seq` numbers the messages of a stream; where it is given, what was lost on the way is counted.
    """

    t: float | Numbers
    value: float | Numbers
    seq: Annotated[int, Field(ge=0, le=2**53)] | None = None


def measurement(t: float | Numbers, value: float | Numbers, seq: int | None = None) -> bytes:
    """The payload of a measurement."""
    return Measurement(t=t, value=value, seq=seq).model_dump_json(exclude_none=True).encode()
