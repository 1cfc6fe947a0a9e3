"""One attempt to learn from recordings, and the refusals of recordings that teach too little."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from incsvr.checks import YOUNG_CURVE_BATCHES, Vehicle, Verdict
from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.traced_motion import traced_free_run_errors
from incsvr.errors import BadInput
from incsvr.learning import checked_learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.excitation import EXCITING_MANOEUVRE, Excitation
from incsvr.learning.free_run import FreeRun, free_runs, motions, rmse
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.body import Coupled
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.coupled import decoupled_streams
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, MEASURED, TorqueKind
from service.commands import other_velocities
from service.commands.config_output import three_digits
from service.commands.declaration import Cures
from service.config.traced_effects import TracedEffects
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import (
    learner_for,
    remarks_of,
    samples_of,
    signals_for,
    wanted_streams,
    with_smoothing,
)

SMOOTHING, TORQUE_KIND = "smoothing", "torque"
"""The signal settings of which alternatives are tried, by their names in the configuration."""
EFFECTS_OVER_ONE = "traced effects apply to damping over one velocity; leave out --effects, or the further inputs"


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
        if SMOOTHING in kept:
            found = with_smoothing(found, signals.smoothing)
        return replace(found, **{name: getattr(signals, name) for name in kept})

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
        whole = [
            {**streams, YAW_RATE: (each.rate_time, each.yaw_rate), TORQUE: (each.torque_time, each.torque)}
            for each, streams in pieces
        ]
        errors = traced_free_run_errors(whole, compensation, lambda rate: model.predict(rate).damping)
        return [
            FreeRun(motion.rate_time, motion.yaw_rate, motion.yaw_rate + error)
            for (motion, _), error in zip(pieces, errors, strict=True)
        ]

    def free_run(self, runs: Sequence[Recording], signals: SignalSettings, model: Model) -> float | None:
        """The root mean square error of free runs over recordings [rad/s]; None where the model runs away."""
        return rmse(self.free_runs(runs, signals, model))


class HeldTooSeldom(BadInput):
    """The refusal of a torque that holds too seldom for a command.

    Attributes:
        measured: the settings under which it gives enough samples.
        because: why, in words.
    """

    def __init__(self, sentence: str, measured: SignalSettings, because: str) -> None:
        super().__init__(sentence)
        self.measured, self.because = measured, because


def too_few(runs: Sequence[Recording], signals: SignalSettings, terms: Terms, count: int, batch: int) -> BadInput:
    """The refusal of recordings that give `count` samples."""
    because = of_a_command(runs, signals, terms, count, batch)
    doubts = [f"{run.name}: {doubt}; " for run in runs for doubt in remarks_of(run, signals.smoothing)]
    return because or BadInput(
        f"{''.join(doubts)}{sequence(runs).name}: {count} damping samples, but one batch needs {batch}; give more or "
        f"longer recordings (a sample every {signals.sample_period:g} s)"
    )


def of_a_command(
    runs: Sequence[Recording], signals: SignalSettings, terms: Terms, count: int, batch: int
) -> HeldTooSeldom | None:
    """The refusal where a torque that is said to be a command is the reason for so few samples, which is tried; None
    where it is not."""
    if signals.torque != COMMANDED:
        return None
    joined = sequence(runs)
    try:
        otherwise = terms.scaled(runs, signals, MEASURED)
        measured = len(terms.samples(joined, otherwise)[0])
    except BadInput:
        return None
    if measured < batch:
        return None
    effort = words_of(joined.axis).effort
    because = f"a sample needs one that is constant for {2.0 * signals.reach:.2g} s, which is rare here"
    return HeldTooSeldom(
        f"{joined.name}: {count} damping samples, because the {effort} is declared a command: {because}; without "
        f"`signals.torque: commanded` there are {measured}",
        otherwise,
        f"the {effort} is used as a measurement, not as a command: {because}",
    )


def refuse_wrong(name: str, verdicts: Sequence[Verdict], cures: Cures) -> None:
    """Refuse recordings of which most is wrong from beginning to end: no curve that is learned of them is right."""
    aside = [verdict for verdict in verdicts if not verdict.learn]
    if 2 * len(aside) > len(verdicts) and sum(verdict.learn for verdict in verdicts) < YOUNG_CURVE_BATCHES:
        raise BadInput(f"{name}: {cures.sentence(aside[0].findings[0])}")


def refuse_unlearned(
    joined: Recording,
    samples: Samples,
    signals: SignalSettings,
    model: Model,
    excitation: Excitation,
    terms: Terms,
    verdicts: Sequence[Verdict],
    batch: int,
    doubt: str | None,
    cures: Cures,
) -> None:
    """Refuse recordings from which too little can be learned, with why, and what to drive.

    Args:
        doubt: what speaks against the declared inertia, or the torque's unit or sign: then no manoeuvre helps.
        cures: what to type where it is the sign.
    """
    idle = not joined.streams()[TORQUE][1].any()
    little = idle or 2 * excitation.driven < batch
    if model.is_trained and not little:
        return
    if doubt is not None:
        raise BadInput(f"{joined.name}: {doubt}")
    undriven_at_all = Excitation(0, excitation.samples, excitation.fastest, None)
    made = in_words_of(joined.axis, (undriven_at_all if idle else excitation).sentence)
    drive = in_words_of(joined.axis, EXCITING_MANOEUVRE)
    pushed = None if idle or terms.coupled is not None else other_velocities.coupling_sentence(joined, samples, signals)
    besides = "" if pushed is None else f"; or other velocities caused it: {pushed}; {other_velocities.VELOCITIES_CURE}"
    doubted = next((each.findings[0] for each in verdicts if each.findings), None)
    why = f"too little motion to learn from: {made}; {drive}"
    if doubted is not None and not little:
        why = f"no samples are usable: {cures.sentence(doubted)}"
    raise BadInput(f"{joined.name}: {why}{besides}")
