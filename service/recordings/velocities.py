"""Velocities that a log has in the world's frame, or of another place, as those of the body where its efforts act."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import VELOCITIES
from service.inputs.settings import Inputs, Vector
from service.recordings.recording import Recording

LINEAR, ANGULAR = VELOCITIES[:3], VELOCITIES[3:]


def heading_at(streams: Streams, at: Array) -> Array | None:
    """The heading at instants (n,) [rad], which counts as the yaw rate does; None where a log has none."""
    if any(name not in streams or streams[name][0].size < 3 for name in ("heading", "yaw_rate")):
        return None
    time, heading = streams["heading"][0], np.unwrap(streams["heading"][1])
    rate = np.interp(time, *streams["yaw_rate"])
    along = float(np.gradient(heading, time) @ rate) >= 0.0
    return np.asarray(np.interp(at, time, heading if along else -heading))


def in_body(recording: Recording, inputs: Inputs) -> Recording:
    """The recording with its velocities as `velocity_frame`, `velocity_north` and `velocity_place` of inputs say them.

    Raises:
        BadInput: what they need is not recorded.
    """
    if inputs.velocity_frame == "body" and not any(inputs.velocity_place):
        return recording
    changed = dict(recording.own_streams)
    if inputs.velocity_frame != "body":
        changed |= _turned(recording.name, recording.own_streams, inputs)
    return replace(recording, own_streams=changed | _displaced(changed, inputs.velocity_place))


def _turned(name: str, streams: Streams, inputs: Inputs) -> dict[str, Stream]:
    first, second = ("sway", "surge") if inputs.velocity_frame == "east_north" else ("surge", "sway")
    if not {"surge", "sway"} <= streams.keys() or heading_at(streams, np.zeros(1)) is None:
        raise BadInput(f"{name}: inputs.velocity_frame needs surge, sway, yaw_rate and heading; name them by --column")
    found = {}
    for each, by in (("surge", -inputs.velocity_north), ("sway", 0.5 * np.pi - inputs.velocity_north)):
        time = streams[each][0]
        heading = heading_at(streams, time)
        assert heading is not None
        north, east = np.interp(time, *streams[first]), np.interp(time, *streams[second])
        found[each] = time, np.cos(heading + by) * north + np.sin(heading + by) * east
    return found


def _displaced(streams: Streams, place: Vector) -> dict[str, Stream]:
    """v − ω × p: the velocities where the efforts act, of those measured at p [m]."""
    found = {}
    for k, name in enumerate(LINEAR):
        if name not in streams:
            continue
        time, values = streams[name]
        one, other = (k + 1) % 3, (k + 2) % 3
        turn = [
            np.interp(time, *streams[ANGULAR[axis]]) if ANGULAR[axis] in streams else np.zeros(time.size)
            for axis in (one, other)
        ]
        found[name] = time, values - (turn[0] * place[other] - turn[1] * place[one])
    return found
