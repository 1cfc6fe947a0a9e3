"""The work of the process beside the learner: a trace of recent data, or a comparison on fresh data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.fresh_data import compare_on_fresh_data
from incsvr.errors import BadInput
from incsvr.learning.freeing import streams_by_itself
from incsvr.learning.model import Model
from incsvr.numerics import Streams
from incsvr.plant.axes import AXES
from incsvr.plant.body import Coupled
from incsvr.signals import REQUIRED
from incsvr.signals.coupled import decoupled_streams
from incsvr.tracing.model import Effect, TracedModel
from incsvr.tracing.result import trace_if_found
from incsvr.tracing.run import as_run


def answer(job: Mapping[str, Any], streams: Streams) -> dict[str, Any]:
    """The result of a piece of work on one axis alone: the terms of its body are subtracted from the torque before.

    What further velocities add to the learned damping a trace finds itself, beside its effects, because the surface was
    learned without those; a comparison subtracts it.

    Raises:
        BadInput: the data cannot answer.
    """
    if "body" in job:
        streams, _ = decoupled_streams(Coupled.from_dict(job["body"]), streams, job["smoothing"])
    if job["work"] != "prove":
        return _trace(job, streams)
    return _compare(job, streams_by_itself(Model.from_dict(job["surface"]), streams) if "surface" in job else streams)


def _trace(job: Mapping[str, Any], streams: Streams) -> dict[str, Any]:
    """The object that `incsvr trace --json` writes, with the time `since` from which on the traced data begin [s].

    Where no effect is found it holds nothing but `effects`, an empty list.

    An effect may have come on in the middle: where the whole says that something changed at an instant, the part after
    it says what; where the whole holds nothing that could be taken up, the part from `half` on may.
    """
    begins = max(float(streams[name][0][0]) for name in REQUIRED)
    whole = _trace_stretch(job, streams, begins)
    usable = _usable(whole)
    newest = min(float(streams[name][0][-1]) for name in REQUIRED)
    changes = [e["parameters"]["at_s"] for e in whole["effects"] if "at_s" in e["parameters"]]
    parts = [at for at in changes if at <= newest - job["shortest"]]
    for since in parts[:1] if usable else [*parts[:1], float(job["half"])]:
        try:
            lately = _trace_stretch(
                job, {name: (t[t >= since], v[t >= since]) for name, (t, v) in streams.items()}, since
            )
        except BadInput:  # the part tells too little for itself
            continue
        if _usable(lately):
            return lately
    return whole


def _trace_stretch(job: Mapping[str, Any], streams: Streams, since: float) -> dict[str, Any]:
    run = replace(as_run(streams, AXES[job["axis"]].rate), rate_limit=job.get("rate_limit"))
    found = trace_if_found([run], inertia=job["inertia"], torque=job.get("torque"))
    if found is None:
        return {"effects": []}
    several = Model.from_dict(job["surface"]).several if "surface" in job else None
    learned = {found.model.axis, *(() if several is None else several.others)}
    # What is a function of the velocities alone is in the learned damping.
    kept = tuple(each for each in found.model.effects if several is None or not _is_of(each, learned))
    names = {each.name for each in kept}
    effects = [each for each in found.effects if several is None or each.effect in names]
    return replace(found, model=replace(found.model, effects=kept), effects=tuple(effects)).to_dict() | {"since": since}


def _is_of(effect: Effect, velocities: set[str]) -> bool:
    """Whether an effect is a function of some velocities alone."""
    remembers = any(row.follows for row in effect.rows)
    return bool(effect.signals) and set(effect.signals) <= velocities and not remembers


def _usable(found: Mapping[str, Any]) -> bool:
    """Whether a trace names an effect that holds on other data, too."""
    return bool(found["effects"]) and bool(
        {each["effect"] for each in found["effects"]} & set(_compensation(found["model"]).names)
    )


def _compare(job: Mapping[str, Any], streams: Streams) -> dict[str, Any]:
    without = None if job["without"] is None else _compensation(job["without"])
    effects = _compensation(job["effects"])
    return asdict(compare_on_fresh_data(streams, job["fresh"], without, effects, job["closed"]))


def _compensation(model: Mapping[str, Any]) -> Compensation:
    return Compensation.of(TracedModel.from_dict(model))
