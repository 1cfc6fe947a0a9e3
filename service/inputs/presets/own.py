"""Our own forms: a table with `t`, the velocity and the effort of an axis, and what the learner hears on its keys."""

from __future__ import annotations

from incsvr.plant.axes import YAW
from service.inputs.presets.proposal import NOTHING_FOUND, Observation, Proposal, first
from service.inputs.settings import Armed, Inputs, Source
from service.inputs.table import ROWS


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of a recording, or of a log of the learner's keys; None where it is neither."""
    tables, axis = [topic for topic in observed.topics if topic.name == ROWS], observed.axis
    table = first(tables, "t", axis.rate, axis.effort) or first(tables, "t", YAW.rate, YAW.effort)
    if table is not None:
        sources = {name: Source(topic=ROWS, field=name, stamp="t") for name in table.fields if name != "t"}
        armed = Armed(topic=ROWS, field="armed", stamp="t") if sources.pop("armed", None) else None
        rate, torque = sources.pop(axis.rate, None), sources.pop(axis.effort, None)
        return Proposal(Inputs(preset="incsvr", yaw_rate=rate, torque=torque, channels=sources, armed=armed))
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
