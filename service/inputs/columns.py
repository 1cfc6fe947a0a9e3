"""Tables, and what the learner hears on its own keys: which columns are which quantity, by their names."""

from __future__ import annotations

import re
from collections.abc import Sequence

from incsvr.plant.axes import YAW
from service.inputs.proposal import NOTHING_FOUND, Observation, Proposal
from service.inputs.settings import Armed, Inputs, Source, StampedBy
from service.inputs.table import ROWS, StampUnit, Topic
from service.inputs.units import FACTORS, unit

_TIMES = ("t", "time", "timestamp", "stamp", "time_s", "date", "datetime", "utc", "header_stamp", "timeus")
_RATES = (
    "yaw_rate",
    "yawrate",
    "yawspeed",
    "r",
    "gyro_z",
    "gyr_z",
    "gyrz",
    "angular_velocity_z",
    "omega_z",
    "wz",
    "q_r",
)
_TORQUES = ("torque", "yaw_torque", "torque_z", "yaw_moment", "moment_z", "tau", "tau_r", "tau_n", "mz", "n")
_NAMES = {"yaw_rate": _RATES, "torque": _TORQUES}
_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\])]+)[\])]\s*$")
_SUFFIXES = ("degps", "dps", "radps", "mradps", "deg_s", "rad_s", "nm", "ms", "us", "ns")


def own(observed: Observation) -> Proposal | None:
    """The mapping of a recording, or of a log of the learner's keys; None where it is neither."""
    tables, axis = [topic for topic in observed.topics if topic.name == ROWS], observed.axis
    table = _with(tables, "t", axis.rate, axis.effort) or _with(tables, "t", YAW.rate, YAW.effort)
    if table is not None:
        sources = {name: Source(topic=ROWS, field=name, stamp="t") for name in table.fields if name != "t"}
        armed = Armed(topic=ROWS, field="armed", stamp="t") if sources.pop("armed", None) else None
        rate, torque = _own_source(observed, table, axis.rate, 2), _own_source(observed, table, axis.effort, 3)
        taken = {name: each for name, each in ((axis.rate, rate), (axis.effort, torque)) if each is not None}
        fields = {each.field for each in taken.values()}
        others = {name: each for name, each in sources.items() if name not in taken and name not in fields}
        reasons = {
            name: (f"{name} is the column {each.field!r}, because the values of {name!r} do not move",)
            for name, each in taken.items()
            if each.field != name
        }
        inputs = Inputs(preset="incsvr", yaw_rate=rate, torque=torque, channels=others, armed=armed)
        return Proposal(inputs, reasons=reasons)
    keys = {topic.name: topic for topic in observed.topics if {"t", "value"} <= set(topic.fields)}
    prefix = next((name.removesuffix("/rate") for name in keys if name.endswith("/rate")), None)
    if prefix is None:
        return None

    def source(key: str) -> Source | None:
        return Source(topic=key, field="value", stamp="t", form="incsvr") if key in keys else None

    begin = f"{prefix}/channel/"
    channels = {name.removeprefix(begin): source(name) for name in keys if name.startswith(begin)}
    torque_key = source(f"{prefix}/torque")
    inputs = Inputs(
        preset="incsvr",
        yaw_rate=source(f"{prefix}/rate"),
        torque=torque_key,
        channels={name: each for name, each in channels.items() if each is not None},
    )
    if torque_key is None:
        return Proposal(inputs, missing={"torque": NOTHING_FOUND["torque"]}, unseen=frozenset({"torque"}))
    return Proposal(inputs)


def _own_source(observed: Observation, table: Topic, name: str, poor: int) -> Source | None:
    """The column of that name, or one that moves where that one's rank is as poor as `poor`, or poorer."""
    if name not in table.fields:
        return None
    is_poor = observed.ranks.get((table.name, name), 0) >= poor
    field = (moving_column(observed, table, name) if is_poor else None) or name
    return Source(topic=table.name, field=field, unit=unit_of(field), stamp="t")


def by_names(observed: Observation) -> Proposal | None:
    """The mapping by names; None where the log is no table."""
    table = _with([topic for topic in observed.topics if topic.name == ROWS])
    if table is None:
        return None
    named = {field: _parts(field) for field in table.fields}
    time = time_column(table.fields)
    stamp = StampedBy() if time is None else StampedBy(stamp=time[0], stamp_unit=time[1])
    missing = {}
    found: dict[str, Source | None] = {}
    for name, names in _NAMES.items():
        field = moving_column(observed, table, name) or _pick(named, names)
        found[name] = None
        if field is None:
            known = ", ".join(table.fields[:12]) or "no column of numbers"
            cure = f"--column {name}=COLUMN" + (":deg/s" if name == "yaw_rate" else "")
            missing[name] = f"no column is recognised as {name} among {known}; name it: {cure}"
        else:
            found[name] = Source(topic=ROWS, field=field, unit=unit_of(field), **stamp)
    if time is None:
        missing["t"] = "no column is recognised as the time; name it: --column t=COLUMN:ms"
    reasons = {name: (f"{name} is the column {each.field!r}, by its name",) for name, each in found.items() if each}
    return Proposal(Inputs(yaw_rate=found["yaw_rate"], torque=found["torque"]), missing=missing, reasons=reasons)


def moving_column(observed: Observation, table: Topic, name: str) -> str | None:
    """The column of a quantity among those whose values move; None where none has a name of the yaw rate's or the
    torque's, or it is neither of them."""
    moving = {field: _parts(field) for field in table.fields if observed.ranks.get((table.name, field), 0) < 2}
    return _pick(moving, _NAMES.get(name, ()))


def time_column(fields: Sequence[str]) -> tuple[str, StampUnit] | None:
    """The column of the time and its unit, by its name; None where no name is known."""
    named = {field: _parts(field) for field in fields}
    time = _pick(named, _TIMES)
    return None if time is None else (time, _stamp_unit(named[time][1]))


def named_column(fields: Sequence[str], name: str) -> str | None:
    """The column of `t`, the yaw rate or the torque by its name; None where no name is known."""
    return _pick({field: _parts(field) for field in fields}, {"t": _TIMES, **_NAMES}.get(name, ()))


def unit_of(field: str) -> str:
    """The unit in a column's name; empty where none is known."""
    spelt = _parts(field)[1]
    return spelt if spelt in FACTORS else ""


def names_unit(field: str) -> bool:
    """Whether a column's name ends with a unit, of a stamp or of another quantity."""
    return _parts(field)[1] != ""


def _parts(field: str) -> tuple[str, str]:
    """Name in small letters without its unit, and the unit: `Yaw rate [deg/s]`, `yaw_rate_degps`, `gyro.z (rad/s)`."""
    bracketed = _UNIT.match(field)
    name, spelt = (bracketed[1], bracketed[2]) if bracketed else (field, "")
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    for suffix in () if bracketed else _SUFFIXES:
        if plain.endswith(f"_{suffix}"):
            plain, spelt = plain.removesuffix(f"_{suffix}"), suffix.replace("_s", "/s")
            break
    return plain, unit(spelt) or ""


def _pick(named: dict[str, tuple[str, str]], names: tuple[str, ...]) -> str | None:
    """The column with the first of the names, or the only one that ends with one of the longer names."""
    for name in names:
        for field, (plain, _) in named.items():
            if plain == name:
                return field
    ends = [field for field, (plain, _) in named.items() if any(plain.endswith(f"_{n}") for n in names if len(n) > 3)]
    return ends[0] if len(ends) == 1 else None


def _stamp_unit(spelt: str) -> StampUnit:
    units: tuple[StampUnit, ...] = ("ms", "us", "ns", "min", "h", "d")
    return next((unit for unit in units if unit == spelt), "s")


def _with(topics: Sequence[Topic], *fields: str) -> Topic | None:
    """The first topic that has all of the fields."""
    return next((topic for topic in topics if all(name in topic.fields for name in fields)), None)
