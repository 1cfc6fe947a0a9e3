"""The part of a recording from one stamp to another; what said last that the vehicle was armed holds on in it."""

from __future__ import annotations

from dataclasses import replace

from service.logs.cutting import Cut, Span, columns_inside, rows_inside
from service.recordings.recording import Recording


def cut_recording(recording: Recording, cut: Cut, since_1970: float | None) -> Recording:
    """The rows of a recording that a cut holds, with the stamps that they have.

    Args:
        since_1970: what makes seconds since 1970 of its stamps [s]; None where nothing says it.

    Raises:
        NothingHeld: there is no row in it.
        BadInput: the cut is a time of day, and nothing says it.
    """
    if not cut or not recording.time.size:
        return recording
    span = Span(float(recording.time[0]), float(recording.time[-1]), since_1970)
    inside = rows_inside(recording.time, cut, span)
    columns = columns_inside(recording.columns, inside)
    displaced = {name: values[inside] for name, values in recording.displaced.items()}
    return replace(recording, time=recording.time[inside], columns=columns, displaced=displaced)
