"""Units in which vehicles speak, what they are in SI, and the names of the quantities that they measure."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection
from math import pi
from typing import TYPE_CHECKING

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, BODY_YAW_RATE, EFFORTS, VELOCITIES, YAW

if TYPE_CHECKING:
    from service.inputs.settings import Source

FRACTION = "fraction"
"""Part of the full thrust: no physical unit until somebody says what the full thrust is."""
KGF_N = 9.80665
"""One kilogram-force [N]."""

_BY_SI_UNIT: dict[str, dict[str, float]] = {
    "": {"": 1.0},
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": pi / 180.0, "cdeg/s": pi / 18000.0, "rpm": pi / 30.0},
    "rad": {"rad": 1.0, "deg": pi / 180.0, "cdeg": pi / 18000.0},
    "N m": {"N m": 1.0, "kN m": 1e3, "kgf m": KGF_N},
    "N": {"N": 1.0, "kN": 1e3, "kgf": KGF_N},
    FRACTION: {FRACTION: 1.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "kn": 1852.0 / 3600.0},
    "V": {"V": 1.0, "mV": 1e-3},
    "µs": {"us": 1.0},
    "°C": {"degC": 1.0},
}
"""SI unit → unit → SI over the unit: µs of a servo pulse and °C stay as they are."""
FACTORS = {name: factor for units in _BY_SI_UNIT.values() for name, factor in units.items()}
SI_UNITS = {name: si for si, units in _BY_SI_UNIT.items() for name in units}
STAMP_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86_400.0}
"""Seconds over the unit of a stamp."""
_SPELLINGS = {
    "degps": "deg/s",
    "dps": "deg/s",
    "°/s": "deg/s",
    "°/sec": "deg/s",
    "degree/s": "deg/s",
    "degrees per second": "deg/s",
    "radians per second": "rad/s",
    "radians/s": "rad/s",
    "deg/sec": "deg/s",
    "degrees/s": "deg/s",
    "radps": "rad/s",
    "rps": "rad/s",
    "rads": "rad/s",
    "rad/sec": "rad/s",
    "mradps": "mrad/s",
    "nm": "N m",
    "n*m": "N m",
    "n.m": "N m",
    "n m": "N m",
    "newtonmeter": "N m",
    "newton*m": "N m",
    "newton metres": "N m",
    "newton meters": "N m",
    "radians": "rad",
    "volts": "V",
    "metres per second": "m/s",
    "meters per second": "m/s",
    "knm": "kN m",
    "mps": "m/s",
    "°": "deg",
    "degrees": "deg",
    "µs": "us",
    "μs": "us",
    "usec": "us",
    "sec": "s",
    "seconds": "s",
    "milliseconds": "ms",
    "microseconds": "us",
    "msec": "ms",
    "minutes": "min",
    "hours": "h",
    "days": "d",
    "°c": "degC",
}


def unit(spelt: str) -> str | None:
    """The unit as it is named here, by any of its spellings; None where there is none such."""
    text = spelt.strip()
    if text in FACTORS or text in STAMP_UNITS:
        return text
    return _SPELLINGS.get(text.lower().replace("·", "*"))


def check_unit(spelt: str, where: str) -> str:
    """The unit as it is named here.

    Raises:
        BadInput: there is none such.
    """
    found = unit(spelt)
    if found is None:
        known = ", ".join(name for name in (*FACTORS, "s", "ms", "ns") if name)
        raise BadInput(f"{where}: there is no unit {spelt!r}; known are {known}")
    return found


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
