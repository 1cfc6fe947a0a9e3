"""The columns of a log by their values: those that a quantity is taken from, for a finite and moving one comes before a
name, and those that seem to be in degrees."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from math import degrees, pi
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams, running_integral
from incsvr.plant.axes import AXES, Axis
from incsvr.signals.scales import white_noise
from service.inputs.column_spec import typed_source, typed_source_with_unit
from service.inputs.owners import base
from service.inputs.presets import NO_RATE_FIELD, RATE_PATHS, ROS2, TORQUE_PATHS
from service.inputs.settings import Inputs, Source
from service.inputs.table import ROWS, Table, Topic
from service.inputs.units import FACTORS
from service.logs.log import Log

_FIELDS = {**RATE_PATHS, **TORQUE_PATHS}
_OF_INSTANCES = {"IMU": "GyrZ", "vehicle_angular_velocity": "xyz[2]"}
"""Messages of which a log may have several, and the field of their yaw rate."""
MIN_TURN_DEVIATIONS = 7.0
"""The fastest turns (99 %) in deviations of the gyro's noise below which a vehicle did not turn: one at rest shows
about 2.5, one carried across a deck 28, a vehicle that is steered 75 and more."""
MIN_TURN_RATIO = 3.0
"""How many times more than the yaw's another axis moves that is named in its stead."""
MAX_NAMED = 4
"""Candidates that are named."""
_AXES = (
    ("angular.z", ("angular.x", "angular.y")),
    ("z", ("x", "y")),
    ("Z", ("X", "Y")),
    ("[2]", ("[0]", "[1]")),
    ("yaw", ("roll", "pitch")),
)
"""The end, or the part, of a field's name that means yaw, and what means the other two axes."""


def rank(values: Array, marked: bool = False) -> int:
    """How poor a candidate is by its values (n,): 0 moving, 1 marked as no measurement, 2 still, 3 constant or none."""
    known = values[np.isfinite(values)]
    if not known.size or not np.ptp(known):
        return 3
    noise = white_noise(np.diff(known, 3)) if known.size > 10 else 0.0
    return 2 if np.quantile(np.abs(known), 0.99) <= MIN_TURN_DEVIATIONS * noise else int(marked)


def ranks(log: Log, topics: Sequence[Topic]) -> dict[tuple[str, str], int]:
    """How poor candidates are: by topic and field, those for yaw rate and torque where there are several."""
    found: dict[tuple[str, str], int] = {}
    fields = {topic.name: _FIELDS.get(topic.type) or _OF_INSTANCES.get(base(topic.name)) for topic in topics}
    wanted = {name: field for name, field in fields.items() if field is not None}
    if len(wanted) > 1:
        for name, table in log.read(wanted).items():
            field = wanted[name]
            if field in table.columns:
                found[name, field] = rank(table.columns[field], _is_marked(table))
    for row in ROS2.rows:
        for name, table in log.read({topic.name for topic in topics if row.moving and topic.type == row.kind}).items():
            found[name, row.field] = rank(table.columns.get(row.field, np.empty(0)))
    if any(topic.name == ROWS for topic in topics):
        table = log.read([ROWS])[ROWS]
        found |= {(ROWS, field): rank(values) for field, values in table.columns.items()}
    return found


def _is_marked(table: Table) -> bool:
    """Whether an Imu's own mark says that it has no rate, which some drivers write beside a good one."""
    return bool((table.columns.get(NO_RATE_FIELD, np.zeros(1)) == -1.0).all())


def turning_instead(log: Log, source: Source, name: str) -> str:
    """The clause on candidates that turn where a source does not, the other axes of its own topic first; or nothing."""
    topics = {topic.name: topic for topic in log.topics}
    own = topics.get(source.topic)
    if own is None:
        return ""
    places = [(own.name, field) for field in other_axes(source.field) if field in own.fields]
    alike = {topic.name: _FIELDS.get(topic.type) for topic in log.topics if topic.name != own.name and topic.type}
    places += [(topic, field) for topic, field in alike.items() if field and field.rpartition(".")[0] in RATE_PARENTS]
    tables = log.read({topic for topic, _ in places} | {own.name})
    usual = _reach(tables, own.name, source.field)
    found = sorted(
        (-reach, place)
        for place in places
        if (reach := _reach(tables, *place)) > MIN_TURN_RATIO * usual and reach > 0.0
    )
    if not found:
        return ""
    named = [
        f"{topic}.{field} (up to {-reach:.2g})" if topic != ROWS else f"{field} (up to {-reach:.2g})"
        for reach, (topic, field) in found[:MAX_NAMED]
    ]
    best = source.model_copy(update={"topic": found[0][1][0], "field": found[0][1][1], "sign": 1})
    return (
        f"; what turns is {', '.join(named)}: if that is the vehicle's yaw, give --column "
        f"{shlex.quote(f'{name}={typed_source_with_unit(best)}')}"
    )


RATE_PARENTS = {path.rpartition(".")[0] for path in RATE_PATHS.values()}


def other_axes(field: str) -> list[str]:
    """The fields of the other two axes beside that of the yaw rate."""
    for mark, others in _AXES:
        if mark == "yaw" and mark in field:
            return [field.replace(mark, other) for other in others]
        if field.endswith(mark):
            return [re.sub(f"{re.escape(mark)}$", other, field) for other in others]
    return []


def _reach(tables: Mapping[str, Table], topic: str, field: str) -> float:
    """How far a field goes from its middle, but for single outliers."""
    values = tables[topic].columns.get(field, np.zeros(1)) if topic in tables else np.zeros(1)
    known = values[np.isfinite(values)]
    return float(np.quantile(np.abs(known - np.median(known)), 0.99)) if known.size else 0.0


ABOUT = {axis.rate: axis for axis in AXES.values() if not axis.along}
"""The rates about an axis, and the axis."""
MAX_OUTLIER_PART = 0.02
"""The part of the values beyond what a vehicle reaches up to which they are single outliers."""
FULL_TURN_DEG = 360.0
"""Degrees of a full turn, within which a heading in degrees stays."""
DEGREES_RATIOS = (0.5, 2.0)
"""The times that 57 a heading moves for the yaw rate's own turning, where one of the two is in degrees."""


def in_degrees(inputs: Inputs, streams: Streams) -> dict[str, str]:
    """Sentences on quantities that seem to be in degrees, by name, with the flag to type."""
    sources: dict[str, Source | None] = {"yaw_rate": inputs.yaw_rate, **inputs.channels}
    found = {
        name: _sentence(name, source, likely_scale(ABOUT[name], _largest(streams[name][1])), "rad/s")
        for name, source in sources.items()
        if name in ABOUT and source is not None and _beyond(name, source, streams)
    }
    heading, rate = sources.get("heading"), sources["yaw_rate"]
    if found or heading is None or rate is None or not {"heading", "yaw_rate"} <= set(streams):
        return found
    ratio = _turning_ratio(*streams["heading"], *streams["yaw_rate"])
    if heading.unit in ("", "rad") and heading_in_degrees(streams["heading"], streams["yaw_rate"]):
        found["heading"] = _sentence("heading", heading, ":deg", "rad")
    if rate.unit in ("", "rad/s") and DEGREES_RATIOS[0] < ratio * degrees(1.0) < DEGREES_RATIOS[1]:
        found["yaw_rate"] = _sentence("yaw_rate", rate, ":deg/s", "rad/s")
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
    texts = sorted({name for table in log.tables.values() for name in table.texts})
    there = f" (only texts: {', '.join(texts[:12])})" if texts else ""
    raise BadInput(
        f"{path}: no column of it holds numbers{there}; a log needs the time, the yaw rate and the torque as numbers"
    )


def _sentence(name: str, source: Source, scale: str, taken: str) -> str:
    place, looks = shlex.quote(f"{name}={typed_source(source)}{scale}"), scale.removeprefix(":")
    return f"{name} looks like {looks if looks != scale else 'raw numbers'} and is read as {taken}: --column {place}"


def likely_scale(axis: Axis, reach: float) -> str:
    """What brings velocities that reach so far [SI] about 1 m/s or 1 rad/s, as it is typed behind a column."""
    units = ("kn", "cm/s", "mm/s") if axis.along else ("deg/s", "mrad/s", "cdeg/s")
    unit = min(units, key=lambda each: abs(np.log(max(reach, 1e-9) * FACTORS[each])))
    if reach * FACTORS[unit] <= axis.fastest:
        return f":{unit}"
    return f"*{10.0 ** -np.ceil(np.log10(reach / axis.fastest)):g}"


def _largest(values: Array) -> float:
    """The largest magnitude of values (n,), but for single outliers."""
    return float(np.quantile(np.abs(values), 0.99))


def _beyond(name: str, source: Source, streams: Streams) -> bool:
    if source.unit not in ("", "rad/s") or name not in streams:
        return False
    return float(np.mean(np.abs(streams[name][1]) > ABOUT[name].fastest)) > MAX_OUTLIER_PART


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
