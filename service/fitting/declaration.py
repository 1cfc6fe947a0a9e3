"""What is declared of a log (inertia, unit and sign of the torque) against what its motion shows, before it is learned
from or traced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.checks.apparent_inertia import ApparentInertia, apparent_inertia
from incsvr.checks.delays import SIGN_DELAYS_S, torque_sign
from incsvr.errors import BadInput
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.settings import TorqueKind
from service.fitting.cures import column, cure, cure_of_sign
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import samples_of, signals_for

DOUBT_HEADLINE = "the declared {inertia} and the {effort} disagree by a factor, see the note"
"""The clause of a headline on a doubted declaration: a template of `AxisWords`."""
PULSE_RANGE_US = (800.0, 2200.0)
"""A servo's pulse is between these [µs]."""
NEUTRAL_PULSE_US = 1500.0
"""A servo's pulse that asks for nothing [µs]."""
MAX_PULSE_OFFSET_US = 500.0
"""A servo's pulse is no farther from its neutral [µs]."""
MIN_PER_CENT = 20.0
"""A log in per cent of full thrust reaches at least this."""
MAX_PER_CENT = 100.0
"""Full thrust."""
DEGREE_FACTORS = 30.0, 110.0
"""Between which factors the inertia seems too small where rad/s are taken for deg/s: 57, and what hides."""
MILLISECOND_FACTORS = 300.0, 3000.0
"""Between which factors the inertia seems too small where stamps in ms are taken for s: a thousand, and what hides."""
MIN_STEP_IN_MILLISECONDS = 1.0
"""Step of a yaw rate from which on its seconds may be milliseconds: a gyro is no faster than 1 kHz."""


@dataclass(frozen=True, slots=True)
class Declaration:
    """The result of comparing the declaration with the motion.

    Attributes:
        runs, unseen: the recordings as they are to be taken: where the torque acts late, with the torque put on time.
        doubt: a sentence where inertia or unit of the torque is wrong by a factor; None where none is.
        note: a sentence on a torque that acts late; None where none does.
        sign: why nothing can be learned, where the vehicle seems to turn against its torque; None where it does not.
    """

    runs: list[Recording]
    unseen: list[Recording]
    doubt: str | None = None
    note: str | None = None
    sign: str | None = None

    @property
    def sentences(self) -> tuple[str, ...]:
        return tuple(each for each in (self.doubt, self.note) if each is not None)


def judge_declaration(
    runs: Sequence[Recording],
    unseen: Sequence[Recording],
    inertia: float,
    torque: TorqueKind | None,
    assume_sign: bool,
) -> Declaration:
    """Judges what is declared of recordings by the `runs`.

    Args:
        inertia: as declared [kg m²].
        torque: what it is, as in SignalSettings.
        assume_sign: the sign of the torque is taken as it is.

    Raises:
        BadInput: the torque is a servo's pulse.
    """
    for recording in (*runs, *unseen):
        _refuse_pulses(recording)
    nothing, words = Declaration(list(runs), list(unseen)), words_of(runs[0].axis)
    try:
        signals = signals_for(runs, inertia, runs[0].axis.fastest, torque)
        joined = sequence(runs)
        samples, _ = samples_of(joined, signals, None)
    except BadInput:  # too slow, too short or at rest: whoever learns or traces says so
        return nothing
    is_slow = float(np.median(np.diff(joined.streams()[YAW_RATE][0]))) >= MIN_STEP_IN_MILLISECONDS
    found = replace(nothing, doubt=_doubt(apparent_inertia(samples, inertia), inertia, runs[0], is_slow))
    counts = torque_sign(samples, inertia, joined.streams()[TORQUE], signals.smoothing)
    if counts is None:
        return found
    if counts.late or (assume_sign and counts.may_be_late):
        note = (
            f"the {words.effort} acts {counts.delay:.2g} s after its stamps, and was shifted by this delay: unshifted, "
            f"the vehicle would seem to turn against its {words.effort}; check the clocks of the two streams, or the "
            "thrusters' dead time"
        )
        on_time, unseen_on_time = ([_later(each, counts.delay) for each in of] for of in (runs, unseen))
        return replace(found, runs=on_time, unseen=unseen_on_time, note=note)
    if assume_sign:
        known = (
            f"{words.effort} and {words.rate} count in opposite directions, and no delay up to {SIGN_DELAYS_S[-1]:g} s"
        )
        return replace(found, sign=f"{known} explains this; {cure('sign assumed', runs[0].axis)}")
    either = f", or the {words.effort} acts {counts.delay:.2g} s after its stamps" if counts.may_be_late else ""
    opposite = f"{words.effort} and {words.rate} count in opposite directions{either}"
    return replace(found, sign=f"{opposite}; turn the sign of one of them ({cure_of_sign(runs[0])})")


def _doubt(shown: ApparentInertia | None, declared: float, run: Recording, is_slow: bool) -> str | None:
    """A sentence where the declared inertia [kg m²] and the torque do not fit each other by a factor.

    Args:
        is_slow: whether the samples come so slowly that their stamps may be milliseconds.
    """
    if shown is None or not shown.contradicts(declared):
        return None
    axis, words = run.axis, words_of(run.axis)
    asks = (
        f"the declared {words.inertia} needs {shown.asked:.2g} times the {words.effort} in this log ({declared:.4g} "
        f"{words.inertia_unit} declared, about {shown.middle:.2g} {words.inertia_unit} by the motion)"
    )
    in_degrees = run.places.get(axis.rate, "").endswith(":deg/s")
    if in_degrees and DEGREE_FACTORS[0] <= shown.middle / declared <= DEGREE_FACTORS[1]:
        mends = cure("radians", axis, column=column(run, axis.rate, ":rad/s"))
        return f"{asks}, as if a {words.rate} in rad/s were read as deg/s, as its name says: {mends}"
    if is_slow and MILLISECOND_FACTORS[0] <= shown.middle / declared <= MILLISECOND_FACTORS[1]:
        return f"{asks}, as if stamps in milliseconds were read as seconds: {cure('milliseconds', axis)}"
    is_whole = bool((run.effort == np.round(run.effort)).all())
    unit, scale = _unit(shown, declared, words.effort, is_whole), column(run, axis.effort, "*SCALE")
    if unit is not None:
        return f"{unit}: {cure('scale', axis, column=scale)}; {asks}: {cure('own inertia', axis)}"
    return f"{asks}: {cure('inertia or scale', axis, column=scale)}"


def _unit(shown: ApparentInertia, declared: float, effort: str, is_whole: bool) -> str | None:
    """The probable unit of a torque that disagrees with the inertia, by its values; None for N m.

    Args:
        is_whole: whether all of them are whole numbers.
    """
    reach = max(abs(shown.largest), abs(shown.smallest))
    too_small = declared > shown.middle
    if too_small and reach <= 1.0:
        return f"the {effort} looks like a share of full thrust (all within ±1)"
    if not too_small and MIN_PER_CENT <= reach <= MAX_PER_CENT:
        return f"the {effort} may be in per cent of full thrust (all within ±{MAX_PER_CENT:g})"
    if not too_small and MAX_PER_CENT < reach <= MAX_PULSE_OFFSET_US:
        return f"the {effort} may be a servo's pulse minus its neutral, in µs (all within ±{MAX_PULSE_OFFSET_US:g})"
    if not too_small and is_whole:
        return f"the {effort} may have lost its decimal mark in the export, as by another locale (all whole numbers)"
    return None


def _refuse_pulses(recording: Recording) -> None:
    """Raises BadInput where the torque never changes its sign and has the values of a servo's pulse, while the vehicle
    turns both ways."""
    streams = recording.streams()
    torque, rate = streams[TORQUE][1], streams["yaw_rate"][1]
    low, high = float(torque.min()), float(torque.max())
    if not (PULSE_RANGE_US[0] <= low < NEUTRAL_PULSE_US < high <= PULSE_RANGE_US[1] and rate.min() < 0.0 < rate.max()):
        return
    words = words_of(recording.axis)
    raise BadInput(
        f"{recording.name}: the {words.effort} looks like a servo's pulse in µs ({low:.4g} to {high:.4g}, about "
        f"{NEUTRAL_PULSE_US:g}): {cure('pulses', recording.axis)}"
    )


def _later(recording: Recording, delay: float) -> Recording:
    """The recording with its effort so much later [s]."""
    streams, effort = recording.own_streams, recording.axis.effort
    time, values = streams[effort]
    return replace(recording, own_streams={**streams, effort: (np.round(time + delay, 9), values)})
