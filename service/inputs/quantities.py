"""The names of quantities that mean something here, their SI units, and names that were meant to be one of them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection

from incsvr.plant.axes import AXES, BODY_YAW_RATE, EFFORTS, VELOCITIES, YAW
from service.inputs.settings import Source
from service.inputs.units import FRACTION, SI_UNITS

TIME_NAME = "t"
_CHANNELS = {"heading": "rad", "depth": "m", "voltage": "V", "temperature": "°C", "armed": ""}
_THRUSTER = re.compile(r"^thruster_\d+_(speed|pwm)$")
_THRUSTER_UNITS = {"speed": "rad/s", "pwm": "µs"}
_MOTION = (*VELOCITIES, *EFFORTS)
QUANTITY_NAMES = (TIME_NAME, *_MOTION, *_CHANNELS)
SYNONYMS = {
    "yaw_rate": ("yawspeed", "yaw_speed", "yaw_velocity", "rate", "gyro", "gyro_z", "angular_velocity", "r"),
    "torque": ("yaw_torque", "torque_z", "yaw_moment", "moment", "tau", "tau_r", "tau_n", "mz"),
    TIME_NAME: ("time", "stamp", "timestamp", "seconds"),
}
"""The words of others for the three that every log needs. None of them is a channel that anything here would look
for."""
MIN_LIKENESS = 0.8
"""The part that is alike of a name and its misspelling."""


def si_unit(name: str) -> str:
    """The SI unit of a quantity; empty where it has none, or the name says nothing here."""
    name = YAW.rate if name == BODY_YAW_RATE else name
    for axis in AXES.values():
        if name == axis.rate:
            return "m/s" if axis.along else "rad/s"
        if name == axis.effort:
            return "N" if axis.along else "N m"
    thruster = _THRUSTER.match(name)
    return _THRUSTER_UNITS[thruster[1]] if thruster else _CHANNELS.get(name, "")


def units_of(name: str, source: Source) -> tuple[str, str]:
    """The unit of a source's numbers in their messages, and the unit in which the quantity is used; empty: unknown."""
    if source.unit == FRACTION:
        return FRACTION, FRACTION if source.scale == 1.0 else si_unit(name)
    used = SI_UNITS[source.unit] or si_unit(name)
    return "" if source.scale != 1.0 else source.unit or used, used  # the unit is that of the scaled numbers


def intended_quantity(name: str, said: Collection[str]) -> str | None:
    """The quantity that a name was meant to be; None where it is one, or a further channel.

    Args:
        said: the names that were given beside it: what is named already was not meant.
    """
    if name in QUANTITY_NAMES or _THRUSTER.match(name):
        return None
    plain = _plain(name)
    for known in QUANTITY_NAMES:
        if known not in said and plain == _plain(known):
            return known
    for known, others in SYNONYMS.items():
        if known not in said and plain in {_plain(other) for other in others}:
            return known
    if any(re.match(rf"{re.escape(known)}[_\d]", name) for known in QUANTITY_NAMES if known != TIME_NAME):
        return None  # another one of the kind, such as depth_2
    # a stream's "kind" in front (front_depth) is a name of its own as well
    longer = [
        known for known in QUANTITY_NAMES if len(known) > 3 and known not in said and not name.endswith(f"_{known}")
    ]
    close = difflib.get_close_matches(name.lower(), longer, n=1, cutoff=MIN_LIKENESS)
    return close[0] if close else None


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "", name.lower())
