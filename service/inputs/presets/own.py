"""Our own forms: a table with `t`, the velocity and the effort of an axis, and what the learner hears on its keys."""

from __future__ import annotations

from incsvr.plant.axes import YAW
from service.inputs.presets.columns import moving_column, unit_of
from service.inputs.presets.proposal import NOTHING_FOUND, Observation, Proposal, first
from service.inputs.settings import Armed, Inputs, Source
from service.inputs.table import ROWS, Topic


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of a recording, or of a log of the learner's keys; None where it is neither."""
    tables, axis = [topic for topic in observed.topics if topic.name == ROWS], observed.axis
    table = first(tables, "t", axis.rate, axis.effort) or first(tables, "t", YAW.rate, YAW.effort)
    if table is not None:
        sources = {name: Source(topic=ROWS, field=name, stamp="t") for name in table.fields if name != "t"}
        armed = Armed(topic=ROWS, field="armed", stamp="t") if sources.pop("armed", None) else None
        rate, torque = _source(observed, table, axis.rate, 2), _source(observed, table, axis.effort, 3)
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


def _source(observed: Observation, table: Topic, name: str, poor: int) -> Source | None:
    """The column of that name, or one that moves where that one's rank is as poor as `poor`, or poorer."""
    if name not in table.fields:
        return None
    is_poor = observed.ranks.get((table.name, name), 0) >= poor
    field = (moving_column(observed, table, name) if is_poor else None) or name
    return Source(topic=table.name, field=field, unit=unit_of(field), stamp="t")
