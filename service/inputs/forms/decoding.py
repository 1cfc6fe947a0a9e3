"""The form of a key's messages, and the number at a path within one.

In the MAVLink of BlueOS's server flags are a number, `{"bits": 81}`, or names with bars between.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import Any

from incsvr.errors import BadInput
from service.inputs.forms import cdr, json5, keelson

MODE_BITS = {
    "SAFETY_ARMED": 128,
    "MANUAL_INPUT_ENABLED": 64,
    "HIL_ENABLED": 32,
    "STABILIZE_ENABLED": 16,
    "GUIDED_ENABLED": 8,
    "AUTO_ENABLED": 4,
    "TEST_ENABLED": 2,
    "CUSTOM_MODE_ENABLED": 1,
}
"""Bits of a heartbeat's base mode (MAV_MODE_FLAG)."""
_PREFIX = "MAV_MODE_FLAG_"


def with_flags(data: Any) -> Any:
    """A message whose base mode, if it has one, is a number, whichever version of the server wrote it."""
    message = data.get("message") if type(data) is dict else None
    if type(message) is not dict or "base_mode" not in message:
        return data
    mode = message["base_mode"]
    if type(mode) is dict:
        mode = mode.get("bits")
    elif type(mode) is str:
        mode = sum(MODE_BITS.get(name.strip().removeprefix(_PREFIX), 0) for name in mode.split("|"))
    return {**data, "message": {**message, "base_mode": mode}}


_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


class Undecodable(Exception):
    """A message does not have the form that was told."""


def decoder(form: str) -> Callable[[bytes], Any]:
    """The decoder of a form (`json`, `incsvr`, `keelson`, `cdr:<type>`); it raises Undecodable.

    Raises:
        BadInput: the type of CDR is not known here.
    """
    if form == "keelson":
        return _raising_undecodable(keelson.decode)
    if form in ("json", "incsvr"):
        return _raising_undecodable(json_message)
    name = form.removeprefix("cdr:")
    if name not in cdr.TYPES:
        known = ", ".join(sorted({each for each in cdr.TYPES if each.startswith(name.partition("/")[0])}))
        raise BadInput(
            f"the type {name} is not read on the bus; "
            + (f"of its package are {known}" if known else "known are those of geometry_msgs, sensor_msgs, std_msgs")
        )
    return _raising_undecodable(lambda payload: cdr.decode(payload, name))


def number(message: Any, path: str) -> float | None:
    """The number at a path such as `angular_velocity.z` or `data[2]`; an empty path is the message itself."""
    for step in _steps(path):
        if isinstance(step, str):
            message = message.get(step) if type(message) is dict else None
        else:
            message = message[step] if type(message) is list and step < len(message) else None
    return as_float(message)


def as_float(value: Any) -> float | None:
    """A number of a message; None where it is none, or beyond all floats."""
    if type(value) is float:
        return value
    if type(value) not in (int, bool):
        return None
    try:
        return float(value)
    except OverflowError:
        return None


@cache
def _steps(path: str) -> tuple[str | int, ...]:
    return tuple(name or int(index) for name, index in _STEP.findall(path))


def json_message(payload: bytes) -> Any:
    """A message in JSON or JSON5, the flags of MAVLink as numbers.

    Raises:
        ValueError: it is neither.
    """
    return with_flags(json5.read(payload))


def _raising_undecodable(read: Callable[[bytes], Any]) -> Callable[[bytes], Any]:
    def decode(payload: bytes) -> Any:
        try:
            return read(payload)
        except ValueError as error:
            raise Undecodable(str(error)) from None

    return decode
