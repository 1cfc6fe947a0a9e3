"""Each log by itself before several are believed together: sign, unit and delay; and the frame of the velocities.

A fault of one recording looks like a change of the vehicle, or spoils the fit of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from math import degrees

import numpy as np

from incsvr.checks.own_motion import (
    MIN_BETTER_RATIO,
    MIN_FRAME_LEFT,
    Filtered,
    Response,
    filtered,
    lever,
    planar,
    response,
    world_frame,
)
from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import words_of
from service.fitting.cures import column, cure, turned
from service.logs.candidates import heading_in_degrees
from service.recordings.log_refusals import refuse_implausible
from service.recordings.recording import Recording
from service.recordings.velocities import heading_at

MIN_SCALE = 1.6
"""Factor of inertia and drag alike from which on one log's effort, or its rate, is in another unit: thrusters vary by
some tenths, and no change of a vehicle makes both grow alike."""
MAX_SCALE_RATIO = 1.25
"""Factor by which inertia and drag may grow apart where it is a unit."""
DEGREES_FACTOR = (0.7 * degrees(1.0), 1.4 * degrees(1.0))
"""Between which factors an inertia shrinks where a rate in degrees is read as one in radians."""
MIN_OTHER_DELAY_S = 0.035
"""Delay beside the others' from which on it is one log's own [s]: two steps of those that are tried."""
MAX_LEFT = 0.05
"""Share of an effort that is left at most where a delay is known well."""


def refuse_dives(runs: Sequence[Recording], unseen: Sequence[Recording] = ()) -> None:
    """Refuses dives of a whole vehicle in which a velocity or an effort is not what its name says.

    Args:
        unseen: dives that are not fitted; the frame of the velocities is judged by the others.

    Raises:
        BadInput: naming the log, and the flag that mends it.
    """
    every, axes = [*runs, *unseen], body_axes(runs)
    for run in every:
        refuse_implausible(run, len(every) > 1)
    refuse_idle(every, axes)
    refuse_odd(every, axes)
    refuse_frame(runs)


MIN_EFFORT = 1e-9
"""The largest effort [N, N m] below which nothing pushes: what is left of thrusts that cancel each other."""


def refuse_idle(runs: Sequence[Recording], axes: Sequence[Axis]) -> None:
    """Refuses logs in which velocities change, and no effort of any of these axes does in any log.

    Raises:
        BadInput: naming the first log, its effort, and where that comes from.
    """
    every = [(axis, run, run.own_streams) for run in runs for axis in axes]
    known = [(axis, run, each) for axis, run, each in every if axis.effort in each and each[axis.effort][0].size]
    if not known or any(float(np.ptp(each[axis.effort][1])) > MIN_EFFORT for axis, _, each in known):
        return
    axis, run, streams = known[0]
    words, source = words_of(axis), run.places.get(axis.effort)
    where = f"its source, {source}" if source else "the thrusters' outputs, directions and frame"
    reach = float(np.max(np.abs(streams[axis.rate][1]), initial=0.0)) if axis.rate in streams else 0.0
    raise BadInput(
        f"{run.name}: the {words.effort} is {float(streams[axis.effort][1][0]):.2g} {words.effort_unit} throughout, "
        f"while the {words.rate} goes up to {reach:.2g} {words.rate_unit}: no effort is recorded; check {where} "
        "(`incsvr inspect FILE` shows what there is)"
    )


def refuse_odd(runs: Sequence[Recording], axes: Sequence[Axis], sign_known: bool = False) -> None:
    """Refuses a log whose effort, or rate, counts otherwise than its motion or the other logs show.

    Args:
        sign_known: signs are taken as they are.

    Raises:
        BadInput: naming the log, and the flag that mends it.
    """
    several = len(runs) > 1
    for axis in axes:
        seen = [(run, found) for run in runs if (found := response(run.own_streams, axis)) is not None]
        words = words_of(axis)
        for run, found in seen:
            if found.opposed and not sign_known:
                opposite = f"{words.name} {words.effort} and {words.rate} count in opposite directions"
                mends = cure("sign of a log", axis, column=turned(run, axis, several)[1])
                raise BadInput(f"{run.name}: {opposite}; {mends}")
        for run, found in seen if several else ():
            others = [other for each, other in seen if each is not run]
            if others:
                _refuse_unit(run, found, others, axis)
                _refuse_delay(run, found, others, axis)


def _refuse_unit(run: Recording, found: Response, others: Sequence[Response], axis: Axis) -> None:
    """Raises BadInput where one log's inertia and drag are both the same multiple of the others'."""
    words = words_of(axis)
    inertia = found.inertia / float(np.median([each.inertia for each in others]))
    speed = float(np.median([each.speed for each in others]))
    if (
        not axis.along
        and DEGREES_FACTOR[0] < 1.0 / max(inertia, 1e-9) < DEGREES_FACTOR[1]
        and found.speed > 5.0 * speed
    ):
        raise BadInput(
            f"{run.name}: its {words.rate} is {found.speed / speed:.2g} times that of the other logs, and its inertia "
            f"1/{1.0 / inertia:.2g} of theirs: {cure('degrees', axis, column=column(run, axis.rate, ':deg/s', True))}"
        )
    drag = found.drag_at(speed) / float(np.median([each.drag_at(speed) for each in others]))
    theirs = [each.inertia for each in others]
    known = max(float(each.left.min()) for each in (found, *others)) < MAX_LEFT
    alike = min(theirs) > 0.0 and max(theirs) / min(theirs) < MIN_SCALE
    if not (known and alike and drag > 0.0 and max(inertia / drag, drag / inertia) < MAX_SCALE_RATIO):
        return
    factor = float(np.sqrt(inertia * drag))
    reach = found.reach / float(np.median([each.reach for each in others]))
    if 1.0 / MIN_SCALE < factor < MIN_SCALE or not 1.0 / MIN_SCALE < reach / factor < MIN_SCALE:
        return  # a lost thruster changes the motion, and not the commands
    if len(others) == 1 and factor > 1.0:
        return
    share = ", as a share of full thrust is (all within ±1)" if found.reach <= 1.0 else ""
    raise BadInput(
        f"{run.name}: all its {words.effort}s are {factor:.3g} times those of the other logs, inertia and drag alike"
        f"{share}: {cure('unit of a log', axis, column=column(run, axis.effort, f'*{1.0 / factor:.3g}', True))}"
    )


def _refuse_delay(run: Recording, found: Response, others: Sequence[Response], axis: Axis) -> None:
    """Raises BadInput where the effort acts later, or earlier, in one log than in the others, which agree."""
    theirs = [each.delay for each in others]
    usual = float(np.median(theirs))
    apart = found.delay - usual
    known = float(found.left.min()) < MAX_LEFT and np.ptp(theirs) <= MIN_OTHER_DELAY_S
    inertia = float(np.median([each.inertia for each in others]))
    known &= inertia / MIN_SCALE < found.inertia < MIN_SCALE * inertia  # where it is none, the delay is none either
    if len(others) == 1:  # of two, the one that is farther from none
        known &= abs(found.delay) > abs(usual)
    if not known or abs(apart) < MIN_OTHER_DELAY_S or float(found.left.min()) > MIN_BETTER_RATIO * found.left_at(usual):
        return
    words = words_of(axis)
    late, early = (words.rate, words.effort) if apart > 0.0 else (words.effort, words.rate)
    raise BadInput(
        f"{run.name}: the {late} is {abs(apart):.2g} s later against the {early} than in the other logs: a filter, or "
        f"the stamps, of this recording; {cure('delay of a log', axis)}"
    )


def _refuse_hands(runs: Sequence[Recording], parts: Sequence[Filtered]) -> None:
    """Raises BadInput where the axes of all logs, or of some, do not count to one side."""
    hands = [planar(part).hands for part in parts]
    if -1 not in hands:
        return
    mixed = 1 in hands
    run = runs[hands.index(-1)]
    both = (column(run, name, "-", mixed) for name in ("sway", "sway_force") if name in run.own_streams)
    raise BadInput(
        f"{run.name}: sway counts in the other direction than surge and yaw (or yaw than surge and sway): the Coriolis "
        f"forces of all of them are reversed; {cure('hands', YAW, column=' '.join(both))}"
    )


def refuse_frame(runs: Sequence[Recording]) -> None:
    """Refuses velocities of another frame, hand or place than the efforts, by their products.

    Raises:
        BadInput: naming what is turned or displaced, and the flag that says it.
    """
    seen = _in_plane(runs)
    if not seen:
        return
    for run, _, _ in seen:
        streams = run.own_streams
        if "heading" in streams and heading_in_degrees(streams["heading"], streams["yaw_rate"]):
            mends = cure("heading", YAW, column=column(run, "heading", ":deg", len(runs) > 1))
            raise BadInput(f"{run.name}: heading looks like degrees and is read as radians: {mends}")
    parts = [part for _, part, _ in seen]
    whole, headings = reduce(Filtered.joined, parts), [each for _, _, each in seen if each is not None]
    found = planar(whole)
    recorded = len(headings) == len(parts)
    heading = np.concatenate(headings) if recorded else None
    frame = None
    if found.left > MIN_FRAME_LEFT and (recorded or len(parts) == 1):
        frame = world_frame(whole, heading, found.left)
    if frame is not None:
        raise BadInput(_of_world(seen[0][0], *frame, recorded))
    _refuse_hands([run for run, _, _ in seen], parts)
    place = lever(whole) if found.left > MIN_FRAME_LEFT else None
    if place is not None:
        ahead = f"{abs(place[0]):.2f} m {'ahead of' if place[0] > 0.0 else 'behind'}"
        raise BadInput(
            f"surge and sway are the velocities of a place {ahead} where the efforts act, and {abs(place[1]):.2f} m "
            f"beside it; {cure('place', YAW, ahead=place[0], aside=place[1])}"
        )


def _of_world(run: Recording, frame: str, mirrored: bool, zero: float, with_heading: bool) -> str:
    """The sentence on velocities in the world's frame, whose north has a heading [rad]."""
    first, second = frame.split("_")
    off = f" of a frame whose north has the heading {degrees(zero):.0f}°" if zero else ""
    looks = f"surge and sway look like velocities to the {first} and {second}{off}: turned by the "
    if not with_heading:
        mends = cure("frame without heading", YAW, frame=frame)
        return f"{looks}integral of the yaw rate, they explain the efforts; {mends}"
    side = "surge" if frame == "east_north" else "sway"
    turn = f"{column(run, side, '-', False)} " if mirrored else ""
    other = ", east counted to the other side than the heading" if mirrored else ""
    north = f" --set inputs.velocity_north={zero:.2f}" if zero else ""
    mends = cure("frame", YAW, column=turn, frame=frame, north=north)
    return f"{looks}heading{other}, they explain the efforts; {mends}"


def _in_plane(runs: Sequence[Recording]) -> list[tuple[Recording, Filtered, Array | None]]:
    """Each log's motion in the plane, and its heading [rad]; none where velocities or efforts lack."""
    streams = [run.own_streams for run in runs]
    velocities, efforts = ("surge", "sway", "yaw_rate"), ("surge_force", "sway_force", "torque")
    names = [name for name in (*velocities, *efforts) if all(name in each and each[name][0].size for each in streams)]
    if len(names) < 5 or not set(velocities) <= set(names):
        return []
    found = [(run, filtered(each, names), each) for run, each in zip(runs, streams, strict=True)]
    return [(run, part, heading_at(each, part.time)) for run, part, each in found if part is not None]


def body_axes(runs: Sequence[Recording]) -> list[Axis]:
    """The axes of which some log has the velocity and the effort."""
    every = [run.own_streams for run in runs]
    return [axis for axis in AXES.values() if any({axis.rate, axis.effort} <= streams.keys() for streams in every)]
