"""The candidates for a quantity by their values: a finite and moving one comes before a name."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.scales import white_noise
from service.inputs.column_spec import typed_source_with_unit
from service.inputs.instances import base
from service.inputs.presets.px4 import YAW_FIELD
from service.inputs.presets.ros import NO_RATE_FIELD, RATE_PATHS, TORQUE_PATHS
from service.inputs.settings import Source
from service.inputs.table import ROWS, Table, Topic
from service.logs.log import Log

_FIELDS = {**RATE_PATHS, **TORQUE_PATHS}
_OF_INSTANCES = {"IMU": "GyrZ", "vehicle_angular_velocity": YAW_FIELD}
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
    """How poor the candidates for yaw rate and torque are, where there are several: by topic and field."""
    found: dict[tuple[str, str], int] = {}
    fields = {topic.name: _FIELDS.get(topic.type) or _OF_INSTANCES.get(base(topic.name)) for topic in topics}
    wanted = {name: field for name, field in fields.items() if field is not None}
    if len(wanted) > 1:
        for name, table in log.read(wanted).items():
            field = wanted[name]
            if field in table.columns:
                found[name, field] = rank(table.columns[field], _is_marked(table))
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
