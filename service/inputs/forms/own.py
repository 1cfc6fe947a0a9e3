"""Our own form: `{"t": 12.34, "value": 0.083}`, or arrays of equal length in both; optional `"seq"`."""

from __future__ import annotations

from typing import Any

from pydantic_core import from_json

from service.wire.json_text import RepeatedName, read_json

MAX_SEQUENCE_NUMBER = 2**53
"""The number up to which numbers of messages are whole in JSON."""
_NUMBERS = {int, float}


class InvalidMeasurement(Exception):
    """A message is no measurement; the one argument is the reason that is counted."""


def parse(payload: bytes) -> tuple[list[Any], list[Any], int | None]:
    """Stamps [s], values and number of a message; the lists have one length and hold numbers alone.

    Raises:
        Refused: the payload has not the contract's form. NaN and infinities pass: the synchroniser counts them.
    """
    try:
        data = from_json(payload)
        if type(data) is dict and payload.count(b'"') != 2 * len(data):  # else no name stands twice
            data = read_json(payload)
    except RepeatedName:
        raise InvalidMeasurement("name_twice") from None
    except ValueError:
        raise InvalidMeasurement("not_json") from None
    if type(data) is not dict or "t" not in data or "value" not in data:
        raise InvalidMeasurement("wrong_form")
    t, value, sequence = data["t"], data["value"], data.get("seq")
    if type(t) is not list and type(value) is not list:
        t, value = [t], [value]
    if type(t) is not list or type(value) is not list or not (sequence is None or type(sequence) is int):
        raise InvalidMeasurement("wrong_type")
    if sequence is not None and not 0 <= sequence <= MAX_SEQUENCE_NUMBER:
        raise InvalidMeasurement("implausible_seq")
    if len(t) != len(value):
        raise InvalidMeasurement("unequal_length")
    if not set(map(type, t)) | set(map(type, value)) <= _NUMBERS:
        raise InvalidMeasurement("wrong_type")
    return t, value, sequence
