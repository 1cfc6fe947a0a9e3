"""Cures that name a column, with the name that the column has in the log that was read."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass

from incsvr.checks import Finding
from incsvr.plant.axes import Axis
from incsvr.plant.words import words_of
from service.recordings.recording import Recording

SIGN = "sign"
"""The kind of a finding that torque and yaw rate count in opposite directions."""
_FACTOR_AND_UNIT = re.compile(r"(\*[0-9.]+(?:[eE][+-]?[0-9]+)?)?(:[^:.]+)?$")


@dataclass(frozen=True, slots=True)
class Cures:
    """What to type for a log whose torque has another unit, or another sign than the yaw rate.

    Attributes:
        scale: the flag that scales the torque.
        turn: which flag turns the sign of which of the two.
    """

    scale: str
    turn: str

    @staticmethod
    def of(recording: Recording) -> Cures:
        """For the log that a recording comes of."""
        axis, places, words = recording.axis, recording.places, words_of(recording.axis)
        torque, rate = places.get("torque"), places.get("yaw_rate")
        scale = f"--column {axis.effort}=…*SCALE" if torque is None else _flag(axis.effort, _scaled(torque))
        if torque is None and rate is not None:  # thrusters make the torque, and no column holds it
            return Cures(scale, f"`{_flag(axis.rate, _turned(rate))}` turns the {words.rate}'s")
        return Cures(scale, f"`{_turning_torque(axis, torque)}` turns the {words.effort}'s")

    @property
    def of_sign(self) -> str:
        """What mends a sign, and the way past the doubt."""
        return f"{self.turn}, --assume-sign uses both as recorded"

    def sentence(self, finding: Finding) -> str:
        """The sentence of a finding, with what mends it at a command line."""
        return f"{finding.sentence} ({self.of_sign})" if finding.kind == SIGN else finding.sentence


def _turning_torque(axis: Axis, place: str | None) -> str:
    return f"--column {axis.effort}=-{axis.effort}" if place is None else _flag(axis.effort, _turned(place))


def _turned(place: str) -> str:
    return place.removeprefix("-") if place.startswith("-") else f"-{place}"


def _scaled(place: str) -> str:
    """A place with a factor that is still to be found in the stead of its own, before its unit."""
    return _FACTOR_AND_UNIT.sub(lambda found: f"*SCALE{found[2] or ''}", place, count=1)


def _flag(name: str, place: str) -> str:
    """`--column` with what stands behind it, as a shell takes it; nothing is quoted that needs no quotes."""
    text = f"{name}={place}"
    return f"--column {text if shlex.quote(text.replace('*', '')) == text.replace('*', '') else shlex.quote(text)}"
