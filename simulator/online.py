"""The learner's loop over recordings: the same samples, batches and models as when they are played onto the bus."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.learner import Iteration, Settings, start, step
from incsvr.learning.model import Model
from incsvr.samples import Samples
from incsvr.signals import REQUIRED, TORQUE, SignalSettings
from simulator.recordings import Recording

PAPER_RATE, PAPER_TORQUE = 0.25, 100.0
"""The range for which the paper's settings were tuned [rad/s], [N m]."""
TORQUE_LIMIT = 1e9
"""Nobody said what torque [N m] is plausible: recordings are taken at their word."""
ROTOR_LAG = 0.2
"""How far rotors commonly trail their command [s]; a filter this wide forgives it where the torque is a command."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Mean absolute and root-mean-square error of a model's damping [N m]."""

    mae: float
    rmse: float

    @staticmethod
    def of(model: Model, samples: Samples) -> Errors:
        residual = model.predict(samples.yaw_rate).damping - samples.damping
        return Errors(float(np.mean(np.abs(residual))), float(np.sqrt(np.mean(residual**2))))


def learn(samples: Samples, settings: Settings) -> Iterator[Iteration]:
    """The iterations over the full batches of `samples`, one after the other; what is left over waits for more."""
    state = start(settings)
    for first in range(0, len(samples) - settings.batch + 1, settings.batch):
        state, iteration = step(settings, state, samples.take(slice(first, first + settings.batch)))
        yield iteration


def signals_for(recordings: Sequence[Recording], inertia: float, rate_limit: float) -> SignalSettings:
    """Signal settings that suit the streams' rates, where none are configured.

    The filter spans the slower stream's samples and a rotor's lag behind its command. The samples stand five of its
    widths apart, where their noise is nearly white, but closer in short recordings: about five hundred are needed.
    """
    periods = []
    for name in REQUIRED:
        streams = [recording.streams()[name] for recording in recordings]
        steps = np.concatenate([np.diff(time) for time, _ in streams])
        if steps.size == 0:
            raise BadInput(f"{recordings[0].name}: {name} holds a single sample; record at least a few seconds")
        periods.append(float(f"{np.median(steps):.2g}"))  # a clock's jitter must not show in the settings
    slower = max(periods)
    smoothing = max(3.0 * slower, ROTOR_LAG)
    duration = sum(float(np.ptp(recording.time)) for recording in recordings)
    return SignalSettings(
        inertia=inertia,
        sample_period=float(np.clip(duration / 500.0, 0.5 * smoothing, 5.0 * smoothing)),
        smoothing=smoothing,
        lateness=0.0,
        gap=min(5.0 * slower, 2.0 * smoothing),
        rate_limit=rate_limit,
        torque_limit=TORQUE_LIMIT,
    )


def learner_for(samples: Samples, **chosen: object) -> Settings:
    """The paper's settings in the units of this vehicle, where none are configured.

    They were tuned for ±0.25 rad/s and ±100 N m; lengths in yaw rate and in torque are scaled to what `samples` span.
    """
    rate = float(np.abs(samples.yaw_rate).max(initial=0.0)) / PAPER_RATE
    torque = float(np.abs(samples.damping).max(initial=0.0)) / PAPER_TORQUE
    if not (rate > 0.0 and torque > 0.0):
        raise BadInput("yaw rate or damping is zero in every sample; give recordings in which the vehicle turns")
    paper = Settings()
    scaled = {
        "gamma": paper.gamma / rate**2,
        "C": paper.C * torque,
        "epsilon": paper.epsilon * torque,
        "near_rate": paper.near_rate * rate,
        "near_damping": paper.near_damping * torque,
        "rate_range": (paper.rate_range[0] * rate, paper.rate_range[1] * rate),
    }
    return Settings(**scaled, **chosen)  # type: ignore[arg-type]


def pauses(recording: Recording, gap: float) -> list[str]:
    """A sentence for each stream of the recording that pauses for longer than `gap` [s]."""
    found = []
    for name in REQUIRED:
        steps = np.diff(recording.streams()[name][0])
        long = steps[steps > gap]
        if long.size:
            found.append(
                f"{recording.name}: {name} pauses {long.size} times for longer than {gap:g} s, {long.sum():.3g} s in "
                "all; no sample stands across a pause"
            )
    return found


def remarks(recordings: Sequence[Recording], samples: Samples, signals: SignalSettings) -> list[str]:
    """What a person should know about the recordings and the settings."""
    found = [f"{recording.name}: {note}" for recording in recordings for note in recording.notes]
    found += [sentence for recording in recordings for sentence in pauses(recording, signals.longest_pause)]
    foreign = foreign_inertia(recordings, samples, signals)
    return found if foreign is None else [*found, foreign]


def foreign_inertia(recordings: Sequence[Recording], samples: Samples, signals: SignalSettings) -> str | None:
    """A sentence where the declared inertia asks for far more than the actuators give, if they give anything."""
    torque = max(float(np.abs(recording.streams()[TORQUE][1]).max()) for recording in recordings)
    damping = float(np.abs(samples.damping).max(initial=0.0))
    if not 0.0 < 5.0 * torque < damping:
        return None
    return (
        f"an inertia of {signals.inertia:g} kg m² asks for {damping:.3g} N m where the actuators give {torque:.3g}; "
        "declare the vehicle's own with --inertia"
    )
