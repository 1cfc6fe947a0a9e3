"""The instance of a message: the bank of outputs, the battery or the sensor that the message names.

Each instance is a topic of its own. Instance 0 keeps the plain name, `SERVO_OUTPUT_RAW`; another one is numbered,
`SERVO_OUTPUT_RAW[1]`, in logs and on a bus alike.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

INSTANCE_FIELDS: Mapping[str, str] = {
    **dict.fromkeys(("SERVO_OUTPUT_RAW", "RC_CHANNELS_RAW", "RC_CHANNELS_SCALED"), "port"),
    **dict.fromkeys(
        (
            "AIRSPEED",
            "BATTERY_STATUS",
            "DISTANCE_SENSOR",
            "GLOBAL_POSITION_SENSOR",
            "HIGHRES_IMU",
            "HYGROMETER_SENSOR",
            "MCU_STATUS",
            "RAW_IMU",
            "SMART_BATTERY_INFO",
            "WATER_DEPTH",
        ),
        "id",
    ),
    **dict.fromkeys(("DEBUG_VECT", "NAMED_VALUE_FLOAT", "NAMED_VALUE_INT", "NAMED_VALUE_STRING"), "name"),
    "ADAP_TUNING": "axis",
    "OPTICAL_FLOW_RAD": "sensor_id",
    "PID_TUNING": "axis",
}
"""The field that tells instances apart, by MAVLink message: those that MAVLink's definitions mark, of measurements."""
_NUMBERED = re.compile(r"^(.*?)\[([^\[\]]+)\]$")


def instance_field(name: str) -> str | None:
    """The field that tells the instances of a MAVLink message apart, by the name of its topic or key."""
    return INSTANCE_FIELDS.get(name.rpartition("/")[2])


def numbered(name: str, which: Any) -> str:
    """The topic of one instance: the plain name for 0 and for what is no number and no name, else `NAME[1]`."""
    if isinstance(which, Mapping):  # JSON writes an enumerated value as {"type": "PID_TUNING_YAW"}
        which = which.get("type")
    if isinstance(which, list):  # and a text as its characters
        which = "".join(map(str, which))
    if isinstance(which, str):
        which = which.partition("\0")[0]
        return f"{name}[{which}]" if which and not set(which) & set("[]/") else name
    if isinstance(which, bool) or not isinstance(which, int | float) or which != which or which == 0:
        return name
    return f"{name}[{which:g}]"


def base(name: str) -> str:
    """The name without its instance."""
    found = _NUMBERED.match(name)
    return found[1] if found else name


def instance(name: str) -> str:
    """The instance that a name bears; empty for the plain one."""
    found = _NUMBERED.match(name)
    return found[2] if found else ""


def in_order(names: Iterable[str]) -> list[str]:
    """Names by their instances: the plain one first, then by number, then by name."""

    def place(name: str) -> tuple[bool, float, str]:
        which = instance(name)
        return (bool(which), float(which) if which.isdecimal() else float("inf"), which)

    return sorted(names, key=place)
