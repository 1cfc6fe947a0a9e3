"""Columns of a log that seem to be in degrees, and logs without a number."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from math import degrees, pi
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, running_integral
from incsvr.plant.axes import AXES
from service.inputs.column_spec import typed_source
from service.inputs.measured_streams import Stream
from service.inputs.settings import Inputs, Source
from service.logs.log import Log

FASTEST_RATES = {axis.rate: axis.fastest for axis in AXES.values() if not axis.along}
"""The rates about an axis, and the fastest that a vehicle turns about it [rad/s]."""
MAX_OUTLIER_PART = 0.02
"""The part of the values beyond what a vehicle reaches up to which they are single outliers."""
FULL_TURN_DEG = 360.0
"""Degrees of a full turn, within which a heading in degrees stays."""
DEGREES_RATIOS = (0.5, 2.0)
"""The times that 57 a heading moves for the yaw rate's own turning, where one of the two is in degrees."""


def in_degrees(inputs: Inputs, streams: Mapping[str, Stream]) -> dict[str, str]:
    """Sentences on quantities that seem to be in degrees, by name, with the flag to type."""
    sources: dict[str, Source | None] = {"yaw_rate": inputs.yaw_rate, **inputs.channels}
    found = {
        name: _sentence(name, source, "deg/s", "rad/s")
        for name, source in sources.items()
        if name in FASTEST_RATES and source is not None and _beyond(name, source, streams)
    }
    heading, rate = sources.get("heading"), sources["yaw_rate"]
    if found or heading is None or rate is None or not {"heading", "yaw_rate"} <= set(streams):
        return found
    ratio = _turning_ratio(*streams["heading"], *streams["yaw_rate"])
    if heading.unit in ("", "rad") and heading_in_degrees(streams["heading"], streams["yaw_rate"]):
        found["heading"] = _sentence("heading", heading, "deg", "rad")
    if rate.unit in ("", "rad/s") and DEGREES_RATIOS[0] < ratio * degrees(1.0) < DEGREES_RATIOS[1]:
        found["yaw_rate"] = _sentence("yaw_rate", rate, "deg/s", "rad/s")
    return found


def heading_in_degrees(heading: Stream, rate: Stream) -> bool:
    """Whether a heading turns 57 times as far as its yaw rate in radians, within one turn in degrees."""
    ratio = _turning_ratio(*heading, *rate)
    return DEGREES_RATIOS[0] < ratio / degrees(1.0) < DEGREES_RATIOS[1] and _compass(heading[1])


def refuse_without_numbers(path: Path, log: Log) -> None:
    """Refuses a log of which nothing can be learned, whatever is said of it.

    Raises:
        BadInput: no message of it holds a number.
    """
    if any(topic.fields for topic in log.topics):
        return
    texts = sorted({name for table in log.read([topic.name for topic in log.topics]).values() for name in table.texts})
    there = f" (only texts: {', '.join(texts[:12])})" if texts else ""
    raise BadInput(
        f"{path}: no column of it holds numbers{there}; a log needs the time, the yaw rate and the torque as numbers"
    )


def _sentence(name: str, source: Source, looks: str, taken: str) -> str:
    place = shlex.quote(f"{name}={typed_source(source)}:{looks}")
    return f"{name} looks like {looks} and is read as {taken}: --column {place}"


def _beyond(name: str, source: Source, streams: Mapping[str, Stream]) -> bool:
    if source.unit not in ("", "rad/s") or name not in streams:
        return False
    return float(np.mean(np.abs(streams[name][1]) > FASTEST_RATES[name])) > MAX_OUTLIER_PART


def _compass(heading: Array) -> bool:
    """Whether a heading goes farther than a turn in radians, and no farther than one in degrees."""
    return bool(np.max(np.abs(heading)) > 2.2 * pi) and bool(np.max(np.abs(heading)) <= FULL_TURN_DEG)


def _turning_ratio(at: Array, heading: Array, time: Array, rate: Array) -> float:
    """The turn of the heading over the integral of the yaw rate; zero if neither moves."""
    if at.size < 3 or time.size < 3:
        return 0.0
    turned = running_integral(time, rate)
    expected = np.abs(np.diff(np.interp(at, time, turned)))
    moved = np.abs(np.diff(heading))
    kept = (expected > 0.0) & (moved < 0.5 * max(float(np.ptp(heading)), 1e-9))  # not where it wraps
    whole = float(expected[kept].sum())
    return float(moved[kept].sum()) / whole if whole > 0.0 else 0.0
