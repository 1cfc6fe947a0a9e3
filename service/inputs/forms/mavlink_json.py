"""MAVLink as JSON, as BlueOS's server writes it: flags are a number, `{"bits": 81}`, or names with bars between."""

from __future__ import annotations

from typing import Any

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
