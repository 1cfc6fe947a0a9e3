"""What all attempts to learn from the same recordings have in common, and the steps of an attempt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from incsvr.checks import Vehicle, Verdict
from incsvr.compensation.effects_in_force import Compensation
from incsvr.errors import BadInput
from incsvr.forecasting.over_recordings import FreeRun, free_runs, motions, rmse, traced_free_runs
from incsvr.learning import checked_learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.body import Coupled
from incsvr.plant.words import words_of
from incsvr.signals import SignalSettings
from incsvr.signals.coupled import decoupled_streams
from incsvr.signals.samples import Samples
from incsvr.signals.settings import TorqueKind
from service.config.traced_effects import TracedEffects
from service.fitting.scaled import three_digits
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import (
    learner_for,
    samples_of,
    signals_for,
    wanted_streams,
    with_smoothing,
)

SMOOTHING, TORQUE_KIND = "smoothing", "torque"
"""The signal settings of which alternatives are tried, by their names in the configuration."""
EFFECTS_OVER_ONE = "traced effects apply to damping over one velocity; leave out --effects, or the further inputs"


def over_scaled(signals: SignalSettings, said: Mapping[str, Any]) -> SignalSettings:
    """Scaled settings with those that a person said, by name; a filter of another width bridges no longer pauses than
    it may."""
    if SMOOTHING in said:
        signals = with_smoothing(signals, said[SMOOTHING])
    return replace(signals, **said)


@dataclass(frozen=True, slots=True)
class Terms:
    """The common parameters of all attempts on the same recordings.

    Attributes:
        learner: its settings; None scales the paper's to the samples.
        chosen: further settings of the learner, such as its policy.
        effects: traced ones that the samples are freed of.
        coupled: the axis in its body, where its mass matrix is declared.
        inputs: the further velocities that damping is learned over.
        sign_known: the torque's sign is taken as it is.
        axis: whose damping is learned.
        by_person: signal settings that a person set: a better one is put in a remark, and they stay.
    """

    learner: Settings | None = None
    chosen: Mapping[str, Any] = field(default_factory=dict)
    effects: TracedEffects | None = None
    coupled: Coupled | None = None
    inputs: tuple[str, ...] = ()
    sign_known: bool = False
    axis: Axis = YAW
    by_person: frozenset[str] = frozenset()

    @property
    def compensation(self) -> Compensation | None:
        return None if self.effects is None else self.effects.compensation

    def samples(self, recording: Recording, signals: SignalSettings) -> tuple[Samples, Mapping[str, int]]:
        """The samples of a recording under these settings, and refused messages by reason."""
        return samples_of(recording, signals, self.compensation, self.coupled, self.inputs)

    def scaled(self, runs: Sequence[Recording], signals: SignalSettings, torque: TorqueKind) -> SignalSettings:
        """The signal settings scaled to the runs anew for another kind of torque, with those that a person set; all
        are new where a person set this kind, because then they only go into a remark."""
        found = three_digits(signals_for(runs, signals.inertia, signals.rate_limit, torque))
        found = replace(found, channels=signals.channels)
        kept = frozenset[str]() if TORQUE_KIND in self.by_person else self.by_person
        return over_scaled(found, {name: getattr(signals, name) for name in kept})

    def settings(self, recording: Recording, samples: Samples) -> Settings:
        """The learner's settings, scaled to the samples where none are given, to the digits that are written down."""
        chosen = dict(self.chosen) | ({"own": recording.axis.rate, "others": self.inputs} if self.inputs else {})
        if self.learner is not None:
            return Settings(**asdict(self.learner) | chosen)
        return three_digits(learner_for(samples, words_of(self.axis), **chosen))

    def learned(
        self,
        samples: Samples,
        signals: SignalSettings,
        settings: Settings,
        each: Callable[[Iteration | None], None] = lambda _: None,
    ) -> tuple[list[Verdict], list[Iteration], Guarded]:
        """The verdicts on the full batches, the iterations, and the learner at the end; `each` is called after every
        batch."""
        vehicle = Vehicle(
            signals.inertia,
            settings.rate_range,
            signals.smoothing,
            self.sign_known,
            words_of(self.axis),
        )
        verdicts: list[Verdict] = []
        iterations: list[Iteration] = []
        guarded = checked_learner.begin(settings)
        for first in range(0, len(samples) - settings.batch + 1, settings.batch):
            batch = samples.take(slice(first, first + settings.batch))
            guarded, verdict, iteration = checked_learner.learn(settings, vehicle, guarded, batch)
            verdicts.append(verdict)
            if iteration is not None:
                iterations.append(iteration)
            each(iteration)
        return verdicts, iterations, guarded

    def free_runs(self, runs: Sequence[Recording], signals: SignalSettings, model: Model) -> list[FreeRun]:
        """The stretches of recordings simulated from their first yaw rates."""
        compensation, coupled = self.compensation, self.coupled
        if compensation is not None and self.inputs:
            raise BadInput(EFFECTS_OVER_ONE)
        pieces = []
        for one in runs:
            streams: Mapping[str, tuple[Array, Array]] = one.streams()
            if compensation is not None:
                streams = wanted_streams(one, signals, True)
                streams = streams if coupled is None else decoupled_streams(coupled, streams, signals.smoothing)[0]
            found = motions(streams, signals.longest_pause)
            if coupled is not None and compensation is None:
                found = [motion.among(coupled, streams, signals.smoothing) for motion in found]
            pieces += [(motion, streams) for motion in found]
        if compensation is None:
            return free_runs(pieces, signals.inertia, model)
        return traced_free_runs(pieces, lambda rate: model.predict(rate).damping, compensation)

    def free_run(self, runs: Sequence[Recording], signals: SignalSettings, model: Model) -> float | None:
        """The root mean square error of free runs over recordings [rad/s]; None where the model runs away."""
        return rmse(self.free_runs(runs, signals, model))
