"""Units in which vehicles speak, and what they are in SI."""

from __future__ import annotations

from math import pi

from incsvr.errors import BadInput

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
STAMP_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds over the unit of a stamp."""
_SPELLINGS = {
    "degps": "deg/s",
    "dps": "deg/s",
    "°/s": "deg/s",
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
    "knm": "kN m",
    "mps": "m/s",
    "°": "deg",
    "degrees": "deg",
    "µs": "us",
    "μs": "us",
    "usec": "us",
    "sec": "s",
    "msec": "ms",
    "°c": "degC",
}


def unit(spelt: str) -> str | None:
    """The unit as it is named here, by any of its spellings; None where there is none such."""
    text = spelt.strip()
    if text in FACTORS or text in STAMP_UNITS:
        return text
    return _SPELLINGS.get(text.lower())


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
