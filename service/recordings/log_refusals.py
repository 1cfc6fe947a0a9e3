"""Logs of which nothing is learned: a vehicle that never turned, a torque that is a part of nobody knows what."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, Axis
from incsvr.plant.words import AxisWords
from incsvr.signals.scales import white_noise
from service.inputs.arming import arming_spans, is_within
from service.inputs.column_spec import of_this_log, typed_source
from service.inputs.measured_streams import MeasuredStreams
from service.inputs.settings import Inputs, Source
from service.inputs.table import Assumption
from service.inputs.units import FRACTION
from service.logs.candidates import MIN_TURN_DEVIATIONS, likely_scale, turning_instead
from service.logs.cutting import EmptyCut
from service.logs.log import Log
from service.recordings.recording import Recording

WILD_FACTOR = 3.0
"""Multiple of an axis's `fastest` beyond which a velocity is no measurement: jolts of real vehicles reach `fastest`."""
GIVEN_TWICE = "data that was fitted proves nothing: give each recording once, to fit or to validate"
"""The harm of a recording that is given twice to a fit or its validation, and the cure."""
DIVE_GIVEN_TWICE = "a dive that counts twice makes changes look surer than they are: give each dive once"
"""The harm of a dive that is given twice to a comparison of dives, and the cure."""


def refuse_fraction(path: Path, inputs: Inputs, measured: MeasuredStreams, words: AxisWords) -> None:
    """Raises BadInput where the torque is a part of what the vehicle can, and nobody said what that is."""
    torque = inputs.torque
    if torque is None or torque.unit != FRACTION or torque.scale != 1.0:
        return
    cure = (
        f"the {words.effort} is a fraction of full thrust, not {words.effort_unit}, until its scale is given: "
        f"--column '{words.effort_column}={typed_source(torque)}*NEWTON_METRES'"
    )
    time, rate = measured.streams[words.rate_column]
    if measured.armed is not None:
        inside = is_within(time, arming_spans(*measured.armed))
        rate = rate[inside] if inside.any() else rate
    still = stillness(rate, words)
    if still is not None:
        raise BadInput(f"{path}: {still}; and {cure}")
    raise BadInput(f"{path}: {cure}")


def refuse_implausible(recording: Recording, several: bool = False) -> None:
    """Raises BadInput where a velocity of any axis is one that no vehicle has: a wild value, or one in another unit."""
    streams = recording.own_streams
    for axis in AXES.values():
        time, values = streams.get(axis.rate, (np.empty(0), np.empty(0)))
        place = recording.places.get(axis.rate, axis.rate)
        if ":" not in place:
            refuse_whole_numbers(recording.name, values, axis, place)
        limit = WILD_FACTOR * axis.fastest
        beyond = np.flatnonzero(np.abs(values) > limit)
        if beyond.size:
            scale = likely_scale(axis, float(np.quantile(np.abs(values), 0.99)))
            cure = shlex.quote(f"{axis.rate}={place.partition(':')[0]}{scale}")
            sentence = (
                f"{recording.name}: {axis.rate} is {values[beyond[0]]:g} at {time[beyond[0]]:.10g} s, beyond the "
                f"plausible ±{limit:g} {'m/s' if axis.along else 'rad/s'}; correct it, or give its unit, such as "
                f"--column {cure}"
            )
            raise BadInput(of_this_log(sentence, recording.name) if several else sentence)


def refuse_twice(recordings: Sequence[Recording], why: str = GIVEN_TWICE) -> None:
    """Refuses the same data given twice, because evidence would count double.

    Raises:
        BadInput: two recordings hold the same velocity and effort, or where these are constant the same of everything,
            sample by sample, whatever their names, stamps and further channels are.
    """
    seen: dict[tuple[bytes, ...], str] = {}
    for recording in recordings:
        own = [recording.rate, recording.effort]
        if not any(np.ptp(values) > 0.0 for values in own):
            own = [values for _, values in recording.own_streams.values()]
        content = tuple(values.tobytes() for values in own)
        if content in seen:
            same = f"holds the same data as {seen[content]}" if recording.name != seen[content] else "is given twice"
            raise BadInput(f"{recording.name} {same}, and {why}")
        seen[content] = recording.name


MIN_WHOLE_VALUES = 20
"""Values of a velocity that are whole numbers by no chance."""


def refuse_whole_numbers(path: Path | str, rate: Array, axis: Axis, place: str) -> None:
    """Raises BadInput where a velocity (n,) has lost its decimals, or its decimal mark."""
    rate = rate[np.isfinite(rate)]
    if rate.size < MIN_WHOLE_VALUES or (rate != np.round(rate)).any() or np.ptp(rate) == 0.0:
        return
    reach = float(np.max(np.abs(rate)))
    flag = shlex.quote(f"{axis.rate}={place}{likely_scale(axis, reach)}")
    cure = f", or give the unit of a raw number, as in --column {flag}" if reach > axis.fastest else ""
    raise BadInput(
        f"{path}: all {rate.size} values of {axis.rate} are whole numbers ({rate.min():g} to {rate.max():g}): the "
        f"export lost their decimals, or their decimal mark, as by another locale; export with points{cure}"
    )


def stillness(rate: Array, words: AxisWords) -> str | None:
    """A sentence where a yaw rate (n,) [rad/s] never leaves its noise."""
    if rate.size < 10:
        return None
    noise = white_noise(np.diff(rate, 3))
    fastest = float(np.quantile(np.abs(rate), 0.99))
    if not rate.any():
        return f"the {words.rate} is zero in every sample"
    if fastest >= MIN_TURN_DEVIATIONS * noise:
        return None
    return (
        f"the {words.rate} never exceeds its noise (99 % of it are below {fastest:.2g} {words.rate_unit} where the "
        f"gyro scatters by {noise:.1g})"
    )


def refuse_still(path: Path, log: Log, source: Source | None, rate: Array, words: AxisWords) -> None:
    """Refuses a log in which the vehicle never turned, naming what does turn in it.

    Raises:
        BadInput: it never did.
    """
    still = stillness(rate, words)
    if still is not None:
        others = "" if source is None else turning_instead(log, source, words.rate_column)
        cure = others or f"; give a log in which the vehicle {words.turns} both ways"
        raise BadInput(f"{path}: {still}{cure}")


@contextmanager
def beside_assumptions(notes: Iterable[str]) -> Iterator[None]:
    """Lets a refusal begin with what was assumed of the logs, by their notes.

    Raises:
        BadInput: whatever refuses.
    """
    try:
        yield
    except BadInput as error:
        assumed = [note for note in dict.fromkeys(notes) if isinstance(note, Assumption) and note not in str(error)]
        if not assumed or isinstance(error, EmptyCut):
            raise
        raise BadInput(f"{'; '.join(assumed)}; {error}") from error


def notes_of(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """The notes on all recordings."""
    return tuple(note for recording in recordings for note in recording.notes)
