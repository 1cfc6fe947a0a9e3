"""Cures that name a column, with the name that the column has in the log that was read."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from incsvr.errors import BadInput
from service.commands.declaration import SCALE
from service.commands.fit_refusals import OF_SIGN
from service.recordings.recording import Recording

_FACTOR_AND_UNIT = re.compile(r"(\*[0-9.]+(?:[eE][+-]?[0-9]+)?)?(:[^:.]+)?$")


@contextmanager
def of_the_log(recordings: Sequence[Recording]) -> Iterator[None]:
    """Within it a refusal tells what to type for the log that these recordings come of.

    Raises:
        BadInput: as it was raised, with the log's names.
    """
    try:
        yield
    except BadInput as error:
        raise type(error)(in_names_of(recordings[0], str(error))) from error


def in_names_of(recording: Recording, text: str) -> str:
    """A sentence with cures, in the names of the log that a recording comes of."""
    effort, rate = recording.axis.effort, recording.axis.rate
    torque = recording.places.get("torque")
    if torque is not None:
        text = text.replace(SCALE, f"--column {_quoted(effort, _scaled(torque))}")
        turned = f"`--column {_quoted(effort, _turned(torque))}` turns the torque's"
    elif "yaw_rate" in recording.places:  # thrusters make the torque, and no column holds it
        turned = f"`--column {_quoted(rate, _turned(recording.places['yaw_rate']))}` turns the yaw rate's"
    else:
        return text
    return text.replace(OF_SIGN.partition(",")[0], turned)


def _turned(place: str) -> str:
    return place.removeprefix("-") if place.startswith("-") else f"-{place}"


def _scaled(place: str) -> str:
    """A place with a factor that is still to be found in the stead of its own, before its unit."""
    return _FACTOR_AND_UNIT.sub(lambda found: f"*SCALE{found[2] or ''}", place, count=1)


def _quoted(name: str, place: str) -> str:
    """What stands behind `--column`, as a shell takes it; nothing is quoted that needs no quotes."""
    text = f"{name}={place}"
    return text if shlex.quote(text.replace("*", "")) == text.replace("*", "") else shlex.quote(text)
