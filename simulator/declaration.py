"""What is declared of a log (inertia, unit and sign of the torque) against what its motion shows, before it is learned
from or traced."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.apparent_inertia import ApparentInertia, apparent_inertia
from incsvr.learning.late_torque import late_torque
from incsvr.samples import Array, Samples
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.settings import TorqueKind
from incsvr.signals.smoothing import smooth
from simulator.online import samples_of, signals_for
from simulator.recordings import Recording, from_streams, sequence

SCALE = "--column torque=…*SCALE"
DOUBTED = "the declared inertia and the torque do not fit each other by a factor, see the note"
"""What a headline says of a declaration that is doubted."""
PULSES, NEUTRAL = (800.0, 2200.0), 1500.0
"""Between which a servo's pulse is, and where it asks for nothing [µs]."""
PER_CENT, LEAST_PER_CENT, HALF_PULSE = 100.0, 20.0, 500.0
"""The largest per cent; what a log in per cent reaches at least; the farthest that a pulse is from its neutral [µs]."""


@dataclass(frozen=True, slots=True)
class Declaration:
    """What the motion says of the declaration.

    Attributes:
        runs, unseen: the recordings as they are to be taken: where the torque acts late, with the torque put on time.
        doubt: a sentence where inertia or unit of the torque is wrong by a factor; None where none is.
        note: a sentence on a torque that acts late; None where none does.
    """

    runs: list[Recording]
    unseen: list[Recording]
    doubt: str | None
    note: str | None

    @property
    def sentences(self) -> tuple[str, ...]:
        return tuple(each for each in (self.doubt, self.note) if each is not None)


def add_sign_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `--assume-sign`, the way past a sign that is doubted."""
    parser.add_argument(
        "--assume-sign", action="store_true", help="the torque's sign is right, whatever the motion seems to say"
    )


def declared(
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
    nothing = Declaration(list(runs), list(unseen), None, None)
    try:
        signals = signals_for(runs, inertia, runs[0].axis.fastest, torque)
        joined = sequence(runs)
        samples, _ = samples_of(joined, signals, None)
    except BadInput:  # too slow, too short or at rest: whoever learns or traces says so
        return nothing
    found = replace(nothing, doubt=_doubt(apparent_inertia(samples, inertia), inertia))
    late = None if assume_sign else _late(joined, samples, signals)
    if late is None:
        return found
    note = (
        f"the torque acts {late:.2g} s after its stamps and was taken as late: without that the vehicle would seem to "
        "turn against its torque; check the clocks of the two streams, or the thrusters' dead time"
    )
    on_time, unseen_on_time = ([_later(each, late) for each in of] for of in (runs, unseen))
    return Declaration(on_time, unseen_on_time, found.doubt, note)


def _doubt(shown: ApparentInertia | None, declared: float) -> str | None:
    """A sentence where the declared inertia [kg m²] and the torque do not fit each other by a factor."""
    if shown is None or not shown.contradicts(declared):
        return None
    unit = _unit(shown, declared)
    scale = f"{unit}: scale it with `{SCALE}`; " if unit else ""
    return (
        f"{scale}the inertia asks for {shown.asked:.2g} times the torque in this log ({declared:.4g} kg m² declared, "
        f"about {shown.middle:.2g} kg m² shown by the motion): check the inertia, or the torque's unit with "
        f"`{SCALE}`; declare the vehicle's own with --inertia"
    )


def _unit(shown: ApparentInertia, declared: float) -> str | None:
    """What a torque that does not fit the inertia looks like, by the values that it has; None where like a torque."""
    reach = max(abs(shown.largest), abs(shown.smallest))
    too_small = declared > shown.middle
    if too_small and reach <= 1.0:
        return "the torque looks like a share of full thrust (all within ±1)"
    if not too_small and LEAST_PER_CENT <= reach <= PER_CENT:
        return f"the torque may be in per cent of full thrust (all within ±{PER_CENT:g})"
    if not too_small and PER_CENT < reach <= HALF_PULSE:
        return f"the torque may be a servo's pulse beside its neutral in µs (all within ±{HALF_PULSE:g})"
    return None


def _refuse_pulses(recording: Recording) -> None:
    """Raises BadInput where the torque never changes its sign and has the values of a servo's pulse, while the vehicle
    turns both ways."""
    streams = recording.streams()
    torque, rate = streams[TORQUE][1], streams["yaw_rate"][1]
    low, high = float(torque.min()), float(torque.max())
    if not (PULSES[0] <= low < NEUTRAL < high <= PULSES[1] and rate.min() < 0.0 < rate.max()):
        return
    raise BadInput(
        f"{recording.name}: the torque looks like a servo's pulse in µs ({low:.4g} to {high:.4g}, about {NEUTRAL:g}): "
        "give the moment in N m in its place, or describe the thrusters in a --config FILE (inputs.thrusters)"
    )


def _late(joined: Recording, samples: Samples, signals: SignalSettings) -> float | None:
    """By how much the torque acts late [s], where that alone makes its sign seem wrong."""
    time, torque = joined.streams()[TORQUE]

    def at(instants: Array) -> Array:
        return smooth(time, torque, instants, smoothing=signals.smoothing, gap=2.0 * signals.smoothing).value

    return late_torque(samples, signals.inertia, at)


def _later(recording: Recording, delay: float) -> Recording:
    """The recording with its torque so much later [s]; what other axes displaced goes with the rest."""
    beside = {f"{name} ": values for name, values in recording.displaced.items()}
    whole = replace(recording, columns={**recording.columns, **beside}, displaced={})
    streams: Mapping[str, tuple[Array, Array]] = whole.streams()
    time, torque = streams[TORQUE]
    moved = from_streams(recording.name, {**streams, TORQUE: (np.round(time + delay, 9), torque)})
    columns = {name: values for name, values in moved.columns.items() if name not in beside}
    displaced = {name: moved.columns[f"{name} "] for name in recording.displaced}
    return replace(recording, time=moved.time, columns=columns, displaced=displaced)
