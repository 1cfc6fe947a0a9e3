"""Checks of stamps and heading over the whole length of a recording, for `fit` and `trace`."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.checks.heading_against_rate import beside_yaw_rate
from incsvr.checks.offsets import offsets, unsteady
from incsvr.errors import BadInput
from incsvr.plant.axes import YAW
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.words import words_of
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE
from incsvr.signals.bursts import bursts, in_bursts
from incsvr.signals.raw import HEADING
from service.recordings.recording import Recording


def refuse_bursts(recording: Recording, names: Sequence[str] = REQUIRED) -> None:
    """Refuses streams whose stamps come in bursts: no acceleration follows from such a yaw rate.

    Raises:
        BadInput: they do.
    """
    for name in names:
        apart = bursts(recording.streams()[name][0])
        if apart is not None:
            raise BadInput(f"{recording.name}: {in_bursts(words_of(recording.axis).stream(name), apart)}")


def remarks_of(recording: Recording, smoothing: float) -> list[str]:
    """A sentence for each thing that is wrong.

    Args:
        smoothing: standard deviation of the filter of both streams [s].
    """
    streams, words = recording.streams(), words_of(recording.axis)
    said = [
        in_bursts(words.stream(name), apart) for name in REQUIRED if (apart := bursts(streams[name][0])) is not None
    ]
    clock = None if said else unsteady(offsets(streams[YAW_RATE], streams[TORQUE], smoothing))
    with_heading = recording.axis == YAW and HEADING in streams
    heading = beside_yaw_rate(streams[YAW_RATE], streams[HEADING]) if with_heading else None
    clock = None if clock is None else in_words_of(recording.axis, clock)
    return [*said, *(each for each in (clock, heading) if each is not None)]
