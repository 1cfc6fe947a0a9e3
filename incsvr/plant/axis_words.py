"""Sentences about yaw, said of another axis: its quantities and units in the place of yaw's.

Every sentence of this project is written of yaw, the paper's axis. Of another one it is the same sentence with other
quantities, so it is told at the edge, where people read it, and nowhere else.
"""

from __future__ import annotations

import re

from incsvr.plant.axes import YAW, Axis

_NAMED = r"(?<!channel )(?<![\w:*.])(?<!--)"
"""Not part of a name such as coupling:torque, torque_lag or coriolis:surge*yaw_rate, nor of a flag or a setting."""

_SYMBOLS = (
    (r"\bN_r\|r\|", "{moment}_{symbol}|{symbol}|"),
    (r"\bN_r\b", "{moment}_{symbol}"),
    (r"\bI( ?)ṙ", r"{inertia}\g<1>{symbol}̇"),
    (r"\bI = ", "{inertia} = "),
    (r"\bd\(r\)", "d({symbol})"),
    (r"\|r\|(?!r)", "|{symbol}|"),
    (r"\br \[", "{symbol} ["),
)
"""SNAME's letters in labels and formulas; before the units, of which one stands behind r."""
_ALONG = (
    *_SYMBOLS,
    (r"yaw rates", "{name} velocities"),
    (r"yaw rate", "{name} velocity"),
    (r"Yaw rate", "{Name} velocity"),
    (r"\bTorque\b", "Force"),
    (_NAMED + r"yaw_rate\b(?!\*)", "{rate}"),
    (_NAMED + r"torque\b(?!\*| curve)", "{effort}"),
    (r"moment of inertia( with its added mass)?", "mass, with its added mass"),
    (r"yaw moment", "{name} force"),
    (r"\bturns the vehicle\b", "pushes the vehicle"),
    (r"\bhardly turns\b", "hardly moves"),
    (r"\bturns at\b", "moves at"),
    (r"\bturns back\b", "pulls back"),
    (r"sense of turning", "direction of motion"),
    (r"(?<!same )(?<!Munk )(?<!this )(?<!the )\bmoment\b", "force"),
    (r"(?<!--)(?<!\.)\binertia\b(?!_)", "mass"),
    (r"N m s²/rad²", "N s²/m²"),
    (r"N m s/rad", "N s/m"),
    (r"N m/rad", "N/m"),
    (r"N m", "N"),
    (r"rad/s", "m/s"),
    (r"kg m²", "kg"),
    (r"degrees per second", "other units"),
    (r"I_z − N_ṙ", "m − {added}"),
    (r"\byaw\b(?!_)", "{name}"),
    (r"\bYaw\b(?!_)", "{Name}"),
)
_ABOUT = (
    *_SYMBOLS,
    (r"yaw rate", "{name} rate"),
    (r"Yaw rate", "{Name} rate"),
    (_NAMED + r"yaw_rate\b(?!\*)", "{rate}"),
    (r"I_z − N_ṙ", "I − {added}"),
    (r"\byaw\b(?!_)", "{name}"),
    (r"\bYaw\b(?!_)", "{Name}"),
)
_ADDED = {"surge": "X_u̇", "sway": "Y_v̇", "heave": "Z_ẇ", "roll": "K_ṗ", "pitch": "M_q̇"}
"""SNAME's added masses."""


def in_words_of(axis: Axis, text: str) -> str:
    """A sentence about yaw, of this axis; of yaw it stays as it is."""
    if axis == YAW:
        return text
    names = {
        "name": axis.name,
        "Name": axis.name.capitalize(),
        "rate": axis.rate,
        "effort": "force",
        "added": _ADDED[axis.name],
        "symbol": axis.symbol,
        "moment": axis.force_symbol,
        "inertia": "m" if axis.along else "I",
    }
    # a flag names columns of a recording, each axis's own
    text = text.replace("--column torque=-torque", f"--column {axis.effort}=-{axis.effort}")
    text = text.replace("--column torque=", f"--column {axis.effort}=")
    for pattern, instead in _ALONG if axis.along else _ABOUT:
        text = re.sub(pattern, instead.format(**names), text)
    return text
