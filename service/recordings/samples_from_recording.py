"""The learner's loop over recordings: the same samples, batches and models as when they are played onto the bus."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.checks.delays import offsets, unsteady
from incsvr.checks.filtered_export import filtered_export
from incsvr.checks.heading_against_rate import beside_yaw_rate
from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.freeing import takes_torque
from incsvr.errors import BadInput
from incsvr.learning.iteration import scaled_to
from incsvr.learning.learner import Iteration, Settings, start, step
from incsvr.learning.model import Model
from incsvr.numerics import Streams, root_mean_square
from incsvr.plant.axes import YAW, stream_of
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.body import Coupled
from incsvr.plant.words import YAW_WORDS, AxisWords, words_of
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE, SignalSettings, synchronise
from incsvr.signals.bursts import bursts, in_bursts
from incsvr.signals.holding import REPEATED_SHARE, held_command
from incsvr.signals.raw import HEADING
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, MAX_PAUSE_S, MEASURED, ROTOR_LAG_S, TorqueKind
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS
from service.recordings.recording import Recording


def refuse_bursts(recording: Recording, names: Sequence[str] = REQUIRED) -> None:
    """Refuses streams whose stamps come in bursts: no acceleration follows from such a yaw rate.

    Raises:
        BadInput: they do.
    """
    for name in names:
        apart = bursts(recording.streams()[name][0])
        if apart is not None:
            raise BadInput(f"{recording.name}: {in_bursts(words_of(recording.axis).stream(name), apart)}")


def remarks_of(recording: Recording, smoothing: float) -> list[str]:
    """A sentence for each thing that is wrong.

    Args:
        smoothing: standard deviation of the filter of both streams [s].
    """
    streams, words = recording.streams(), words_of(recording.axis)
    said = [
        in_bursts(words.stream(name), apart) for name in REQUIRED if (apart := bursts(streams[name][0])) is not None
    ]
    clock = None if said else unsteady(offsets(streams[YAW_RATE], streams[TORQUE], smoothing))
    if clock is None and not said and (exported := filtered_export(streams[YAW_RATE], streams[TORQUE])) is not None:
        said.append(words.fill(exported))
    with_heading = recording.axis == YAW and HEADING in streams
    heading = beside_yaw_rate(streams[YAW_RATE], streams[HEADING]) if with_heading else None
    clock = None if clock is None else in_words_of(recording.axis, clock)
    return [*said, *(each for each in (clock, heading) if each is not None)]


RATE_BINS = 10
"""Bins of the rates between RATE_QUANTILES."""
RATE_QUANTILES = (0.01, 0.99)
"""Quantiles of the rates between which a command must have held in every bin."""
MIN_HELD_WINDOWS = 3
"""Windows in which a command held, that every bin of the rates has at least, where it was passed so often."""
TORQUE_LIMIT_NM = 1e9
"""Nobody said what torque [N m] is plausible: recordings are taken at their word."""
MIN_HELD_SMOOTHING_S = 0.1
"""The narrowest filter [s] beside a command that holds, where nothing but the gyro asks for one: its noise grows as the
filter shrinks, and few vehicles move faster."""
MIN_HELD_SHARE = 0.1
"""Share of the time for which a command must hold throughout a filter's window to be learned from there alone."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Mean absolute and root-mean-square error of a model's damping [N m]."""

    mae: float
    rmse: float

    @staticmethod
    def of(model: Model, samples: Samples) -> Errors:
        residual = model.at(samples).damping - samples.damping
        return Errors(float(np.mean(np.abs(residual))), root_mean_square(residual))


def learn(samples: Samples, settings: Settings) -> Iterator[Iteration]:
    """The iterations over the full batches of `samples`, one after the other; what is left over waits for more."""
    state = start(settings)
    for first in range(0, len(samples) - settings.batch + 1, settings.batch):
        state, iteration = step(settings, state, samples.take(slice(first, first + settings.batch)))
        yield iteration


def signals_for(
    recordings: Sequence[Recording],
    inertia: float,
    rate_limit: float,
    torque: TorqueKind | None = None,
) -> SignalSettings:
    """Signal settings that suit the streams' rates, where none are configured.

    The filter spans the slower stream's samples and a rotor's lag behind its command; where the torque is a command
    that was logged while it held, the gyro's samples alone. The samples stand five of its widths apart, where their
    noise is nearly white, but closer in short recordings: about five hundred are needed.
    """
    periods = []
    for name in REQUIRED:
        streams = [recording.streams()[name] for recording in recordings]
        steps = np.concatenate([np.diff(time) for time, _ in streams])
        if steps.size == 0:
            raise BadInput(f"{recordings[0].name}: {name} holds a single sample; record at least a few seconds")
        periods.append(float(f"{np.median(steps):.2g}"))  # a clock's jitter must not show in the settings
    slower = periods[REQUIRED.index(YAW_RATE)] if torque == COMMANDED else max(periods)
    smoothing = max(3.0 * slower, ROTOR_LAG_S)
    steps = np.concatenate([np.diff(recording.time) for recording in recordings])
    duration = float(steps[steps <= MAX_PAUSE_S].sum())  # nothing is sampled in a pause
    narrow = max(3.0 * periods[REQUIRED.index(YAW_RATE)], MIN_HELD_SMOOTHING_S)
    share = 0.0 if torque == MEASURED else _held_share(recordings, narrow)
    if narrow <= smoothing and share >= MIN_HELD_SHARE:
        return SignalSettings(
            inertia=inertia,
            sample_period=float(np.clip(share * duration / 500.0, 0.5 * narrow, 5.0 * narrow)),
            smoothing=narrow,
            lateness=0.0,
            rate_limit=rate_limit,
            torque_limit=TORQUE_LIMIT_NM,
            torque=COMMANDED,
        )
    return SignalSettings(
        inertia=inertia,
        sample_period=float(np.clip(duration / 500.0, 0.5 * smoothing, 5.0 * smoothing)),
        smoothing=smoothing,
        lateness=0.0,
        gap=None if torque == COMMANDED else min(5.0 * slower, 2.0 * smoothing, MAX_PAUSE_S),
        rate_limit=rate_limit,
        torque_limit=TORQUE_LIMIT_NM,
        torque=torque or MEASURED,
    )


def with_smoothing(signals: SignalSettings, smoothing: float) -> SignalSettings:
    """The settings with a filter of another width [s], which bridges no longer pauses than it may."""
    gap = None if signals.gap is None else min(signals.gap, 2.0 * smoothing)
    return replace(signals, smoothing=smoothing, gap=gap)


def _held_share(recordings: Sequence[Recording], smoothing: float) -> float:
    """For which share of the time a torque that repeats itself held for a whole window of this filter [s]; 0 where it
    does not repeat itself, or where the vehicle passes over some of its rates too fast for such a window."""
    streams = [recording.streams() for recording in recordings]
    same = np.concatenate([np.diff(each[TORQUE][1]) == 0.0 for each in streams])
    if same.size == 0 or np.mean(same) <= REPEATED_SHARE:
        return 0.0
    rates, known = [], []
    for each in streams:
        (time, rate), (stamps, command) = each[YAW_RATE], each[TORQUE]
        at = np.arange(time[0], time[-1], smoothing)
        rates.append(np.interp(at, time, rate))
        known.append(held_command(stamps, command, at, HALF_WINDOW_WIDTHS * smoothing, MAX_PAUSE_S).complete)
    everywhere, there = np.concatenate(rates), np.concatenate(known)
    if there.size == 0:
        return 0.0
    slowest, fastest = np.quantile(everywhere, RATE_QUANTILES).tolist()
    edges = np.linspace(slowest, fastest, RATE_BINS + 1)
    seen, told = (np.histogram(values, edges)[0] for values in (everywhere, everywhere[there]))
    return float(there.mean()) if (told >= np.minimum(seen, MIN_HELD_WINDOWS)).all() else 0.0


def learner_for(samples: Samples, words: AxisWords = YAW_WORDS, **chosen: object) -> Settings:
    """The paper's settings in the units of this vehicle, where none are configured.

    They were tuned for ±0.25 rad/s and ±100 N m; lengths in yaw rate and in torque are scaled to what `samples` span.
    """
    rate = float(np.abs(samples.yaw_rate).max(initial=0.0))
    damping = float(np.abs(samples.damping).max(initial=0.0))
    if not (rate > 0.0 and damping > 0.0):
        raise BadInput(
            f"{words.rate} or damping is zero in every sample; give recordings in which the vehicle {words.turns}"
        )
    return scaled_to(rate, damping, **chosen)


def pauses(recording: Recording, gap: float) -> list[str]:
    """A sentence for each stream of the recording that pauses for longer than `gap` [s]."""
    found = []
    for name in REQUIRED:
        steps = np.diff(recording.streams()[name][0])
        long = steps[steps > gap]
        if long.size:
            found.append(
                f"{recording.name}: {name} pauses {long.size} times for longer than {gap:g} s, {long.sum():.3g} s in "
                "all; no sample spans a pause"
            )
    return found


def remarks(recordings: Sequence[Recording], signals: SignalSettings) -> list[str]:
    """The remarks on the recordings and the settings."""
    found = [f"{recording.name}: {note}" for recording in recordings for note in recording.notes]
    found += [sentence for recording in recordings for sentence in pauses(recording, signals.longest_pause)]
    found += [
        f"{recording.name}: {sentence}"
        for recording in recordings
        for sentence in remarks_of(recording, signals.smoothing)
    ]
    return found


def wanted_streams(recording: Recording, signals: SignalSettings, with_channels: bool) -> Streams:
    """The streams that samples are made of; the channels where effects or other velocities are in force."""
    streams = recording.streams()
    names = (*REQUIRED, *(signals.channels if with_channels else ()))
    for name in names:
        if name not in streams:
            raise BadInput(f"{recording.name}: there is no channel {name}, which every sample needs; leave it out")
    measured = (HEADING,) if HEADING in streams and streams[HEADING][0].size else ()
    return {name: streams[name] for name in dict.fromkeys((*names, *measured))}


def samples_of(
    recording: Recording,
    signals: SignalSettings,
    compensation: Compensation | None,
    coupled: Coupled | None = None,
    inputs: tuple[str, ...] = (),
) -> tuple[Samples, Mapping[str, int]]:
    """The samples of a recording, free of what effects and other velocities take, and refused messages by reason.

    Args:
        inputs: channels over which damping is learned; samples without one of them are left out.

    Raises:
        BadInput: there is none.
    """
    with_channels = compensation is not None or coupled is not None or bool(inputs)
    signals = replace(signals, channels=tuple(dict.fromkeys((*signals.channels, *inputs))))
    if coupled is not None:
        others = (stream_of(coupled.axis, name) for name in coupled.velocities)
        signals = replace(signals, channels=tuple(dict.fromkeys((*signals.channels, *others))))
    takes = takes_torque(signals, compensation, coupled)
    samples, rejected = synchronise(signals, wanted_streams(recording, signals, with_channels), takes)
    samples = samples.take(samples.known(inputs))
    if len(samples) == 0:
        refuse_bursts(recording)
        gaps = pauses(recording, signals.longest_pause)
        reasons = gaps or [f"it is shorter than {2 * signals.reach:g} s"]
        cure = "record faster, or allow longer gaps" if gaps else "record longer"
        raise BadInput(f"{recording.name}: not one damping sample; {'; '.join(reasons)}; {cure}")
    return samples, rejected
