"""The sensors of recordings that are to be traced: refused, mended or remarked before their motion is believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.checks import Vehicle
from incsvr.checks.resolution import resolution_fault
from incsvr.errors import BadInput
from incsvr.learning.checked_learner import Sensors, examine
from incsvr.plant.axes import products
from incsvr.plant.words import words_of
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE, synchronise
from incsvr.signals.raw import HEADING
from incsvr.signals.settings import MEASURED
from service.fitting.cures import SIGN, with_cure
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import learner_for, refuse_bursts, remarks_of, signals_for

SLOW_TORQUE_PERIODS = 1.6
"""Periods of the yaw rate that one of the torque lasts at least to be called slow."""


def examine_sensors(recordings: Sequence[Recording], inertia: float, sign_known: bool = False) -> list[Sensors]:
    """The findings of the checks on each recording's sensors, with the settings of `incsvr fit`.

    Args:
        inertia: as declared [kg m²].
        sign_known: the torque's sign is taken as it is.

    Raises:
        BadInput: the yaw rate comes in bursts.
    """
    for recording in recordings:
        refuse_bursts(recording, (YAW_RATE,))
    return [_examined(recording, inertia, sign_known) for recording in recordings]


def with_heading_sign(recordings: Sequence[Recording], sensors: Sequence[Sensors]) -> list[Recording]:
    """The recordings, each with a heading that counts as its yaw rate does.

    Raises:
        BadInput: a recording after whose sensors nothing is to be concluded; it says what to leave out.
    """
    for recording, said in zip(recordings, sensors, strict=True):
        if said.refusal is not None:
            rows = "" if said.refusal.kind == SIGN else ", and leave these rows out"
            raise BadInput(f"{recording.name}: {with_cure(said.refusal, recordings[0])}{rows}")
    return [
        replace(recording, own_streams={**(own := recording.own_streams), HEADING: (own[HEADING][0], -own[HEADING][1])})
        if said.heading_reversed
        else recording
        for recording, said in zip(recordings, sensors, strict=True)
    ]


def sensor_notes(recordings: Sequence[Recording], sensors: Sequence[Sensors], explained: bool) -> list[str]:
    """The notes on the sensors.

    Args:
        explained: the tracer found what moves the vehicle otherwise than the declared model; else it is said here.
    """
    sentences = []
    for recording, said in zip(recordings, sensors, strict=True):
        of_it = [*recording.notes, *said.remarks, *(() if explained else said.of_the_model)]
        if said.heading_reversed:
            of_it.append("the heading's sign was inverted")
        sentences += [f"{recording.name}: {sentence}" for sentence in of_it]
    return sentences


def has_coriolis_pair(recording: Recording) -> bool:
    """Whether two velocities were recorded whose product pushes along the axis: Coriolis, Munk."""
    recorded = tuple(recording.velocities)
    return any(recording.axis.rate not in pair for pair in products(recording.axis, recorded))


def _examined(recording: Recording, inertia: float, sign_known: bool) -> Sensors:
    try:
        signals = signals_for([recording], inertia, recording.axis.fastest)
        streams = recording.streams()
        wanted = [*REQUIRED, *(name for name in (HEADING,) if name in streams and streams[name][0].size)]
        samples, _ = synchronise(signals, {name: streams[name] for name in wanted})
        settings = learner_for(samples)
    except BadInput:  # too short, or at rest: the tracer says so itself
        return Sensors((), (), None, False)
    vehicle = Vehicle(inertia, settings.rate_range, signals.smoothing, sign_known, words_of(recording.axis))
    sensors = examine(samples, settings, vehicle, has_coriolis_pair(recording))
    slow = _slow_torque(recording, inertia)
    further = (*remarks_of(recording, signals.smoothing), *(() if slow is None else (slow,)))
    return replace(sensors, remarks=(*sensors.remarks, *further))


def _slow_torque(recording: Recording, inertia: float) -> str | None:
    """The note on a torque that is sampled so much slower than the yaw rate that the motion between its messages is
    unknown."""
    periods = [float(np.median(np.diff(recording.streams()[name][0]))) for name in REQUIRED]
    if periods[REQUIRED.index(TORQUE)] < SLOW_TORQUE_PERIODS * periods[REQUIRED.index(YAW_RATE)]:
        return None
    try:
        signals = signals_for([recording], inertia, recording.axis.fastest, MEASURED)
        samples, _ = synchronise(signals, {name: recording.streams()[name] for name in REQUIRED})
    except BadInput:
        return None
    quick = resolution_fault(samples, signals.smoothing)
    if quick is None:
        return None
    words = words_of(recording.axis)
    return (
        f"the {words.effort} is sampled every {quick.torque_period:.2g} s, too seldom for this vehicle: linear "
        f"interpolation between its messages makes the curve about {100.0 * quick.share:.0f} % wrong at "
        f"{quick.rate:.2g} {words.rate_unit}; a trace that finds nothing proves nothing here: log the {words.effort} "
        f"every {quick.yaw_rate_period:.2g} s"
    )
