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
    """The flags that correct the unit or the sign of a log's torque.

    Attributes:
        scale: the flag that scales the torque.
        turn: which flag turns the sign of which of the two.
    """

    scale: str
    turn: str

    @staticmethod
    def of(recording: Recording) -> Cures:
        """The cures for the log of a recording."""
        axis, places, words = recording.axis, recording.places, words_of(recording.axis)
        torque, rate = places.get("torque"), places.get("yaw_rate")
        scale = f"--column {axis.effort}=…*SCALE" if torque is None else _flag(axis.effort, _scaled(torque))
        if torque is None and rate is not None:  # thrusters make the torque, and no column holds it
            return Cures(scale, f"`{_flag(axis.rate, _turned(rate))}` turns the {words.rate}'s")
        return Cures(scale, f"`{_turning_torque(axis, torque)}` turns the {words.effort}'s")

    @property
    def of_sign(self) -> str:
        """The flags that turn a sign, or declare that it is right."""
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
