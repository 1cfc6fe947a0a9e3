"""The online loop over recordings: as it is asked for, or under signal settings that were tried and are better."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from incsvr.checks import YOUNG_CURVE_BATCHES, Verdict
from incsvr.checks.resolution import ResolutionFault, resolution_fault
from incsvr.errors import BadInput
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.excitation import EXCITING_MANOEUVRE, Excitation
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, MEASURED
from service.cli.progress import progress, without_bars
from service.fitting.cures import cure, with_cure
from service.fitting.declaration import Declaration
from service.fitting.other_velocities import coupling_sentence
from service.fitting.terms import SMOOTHING, TORQUE_KIND, Terms
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import Errors, remarks_of, with_smoothing


@dataclass(frozen=True, slots=True)
class Training:
    """The course of the online loop.

    Attributes:
        signals, settings: those in force.
        samples: all that the recordings gave.
        rejected: messages of all recordings refused, by reason.
        verdicts: on the full batches.
        iterations: one for each batch that was learned, or taken back.
        guarded: the learner and its checks after the last one.
        errors: on the unseen recordings after each iteration, None before anything is learned; empty without them.
        said: remarks on signal settings that were tried.
    """

    signals: SignalSettings
    settings: Settings
    samples: Samples
    rejected: Mapping[str, int]
    verdicts: Sequence[Verdict]
    iterations: Sequence[Iteration]
    guarded: Guarded
    errors: Sequence[Errors | None]
    said: tuple[str, ...] = ()

    @property
    def model(self) -> Model:
        return self.iterations[-1].model

    @property
    def undriven(self) -> Samples:
        """The samples that are no evidence."""
        return Samples.concatenate(iteration.undriven for iteration in self.iterations)

    @property
    def excitation(self) -> Excitation:
        learned = self.samples.take(slice(0, len(self.iterations) * self.settings.batch))
        return Excitation.of(learned, self.undriven)


def best_training(
    runs: Sequence[Recording],
    unseen: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    declaration: Declaration,
) -> Training:
    """The loop under these signal settings, or under others that are better, with remarks on them.

    Raises:
        BadInput: too little can be learned.
    """
    said, in_force = list[str](), frozenset[str]()
    try:
        training = _training(runs, unseen, signals, terms)
    except HeldTooSeldom as error:
        if TORQUE_KIND in terms.by_person:
            raise
        training = _training(runs, unseen, error.measured, terms)
        said, in_force = [error.because], frozenset({TORQUE_KIND})
    while True:
        _refuse(runs, training, terms, declaration)
        doubted = declaration.doubt is not None
        quick = None if doubted else resolution_fault(training.samples, training.signals.smoothing)
        best = None
        if quick is not None:
            remark, best = alternative(quick, runs, unseen, terms, training, in_force)
            said += [] if remark is None else [remark]
        if best is None:
            return replace(training, said=tuple(said))
        training, in_force = best.training, in_force | {best.setting}


def _training(
    runs: Sequence[Recording], unseen: Sequence[Recording], signals: SignalSettings, terms: Terms
) -> Training:
    """The loop over all full batches of the runs, with the error on the unseen ones after each iteration.

    Raises:
        BadInput: there is not one full batch.
    """
    joined = sequence(runs)
    try:
        samples, rejected = terms.samples(joined, signals)
    except BadInput as error:
        raise _of_a_command(runs, signals, terms, 0, 1) or error from None
    settings = terms.settings(joined, samples)
    if len(samples) < settings.batch:
        raise _too_few(runs, signals, terms, len(samples), settings.batch)
    validation, more = terms.samples(sequence(unseen), signals) if unseen else (Samples.empty(), {})
    errors: list[Errors | None] = []
    with progress("learning", len(samples) // settings.batch) as advance:

        def judge(iteration: Iteration | None) -> None:
            if iteration is not None and unseen:
                errors.append(Errors.of(iteration.model, validation) if iteration.model.is_trained else None)
            advance()

        verdicts, iterations, guarded = terms.learned(samples, signals, settings, judge)
    every = Counter(rejected) + Counter(more)
    return Training(signals, settings, samples, every, verdicts, iterations, guarded, errors)


class HeldTooSeldom(BadInput):
    """The refusal of a torque that holds too seldom for a command.

    Attributes:
        measured: the settings under which it gives enough samples.
        because: why, in words.
    """

    def __init__(self, sentence: str, measured: SignalSettings, because: str) -> None:
        super().__init__(sentence)
        self.measured, self.because = measured, because


def _too_few(runs: Sequence[Recording], signals: SignalSettings, terms: Terms, count: int, batch: int) -> BadInput:
    """The refusal of recordings that give `count` samples."""
    because = _of_a_command(runs, signals, terms, count, batch)
    doubts = [f"{run.name}: {doubt}; " for run in runs for doubt in remarks_of(run, signals.smoothing)]
    return because or BadInput(
        f"{''.join(doubts)}{sequence(runs).name}: {count} damping samples, but one batch needs {batch}; give more or "
        f"longer recordings (a sample every {signals.sample_period:g} s)"
    )


def _of_a_command(
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


def _refuse(runs: Sequence[Recording], training: Training, terms: Terms, declaration: Declaration) -> None:
    """Refuses recordings of which most is wrong from beginning to end, because no curve that is learned of them is
    right; and those from which too little can be learned, with why, and what to drive."""
    joined, verdicts, batch = sequence(runs), training.verdicts, training.settings.batch
    aside = [verdict for verdict in verdicts if not verdict.learn]
    if 2 * len(aside) > len(verdicts) and sum(verdict.learn for verdict in verdicts) < YOUNG_CURVE_BATCHES:
        raise BadInput(f"{joined.name}: {with_cure(aside[0].findings[0], runs[0])}")
    idle, excitation = not joined.streams()[TORQUE][1].any(), training.excitation
    little = idle or 2 * excitation.driven < batch
    if training.model.is_trained and not little:
        return
    wrong = declaration.sign or declaration.doubt
    if wrong is not None:  # then no manoeuvre helps
        raise BadInput(f"{joined.name}: {wrong}")
    undriven_at_all = Excitation(0, excitation.samples, excitation.fastest, None)
    made = in_words_of(joined.axis, (undriven_at_all if idle else excitation).sentence)
    drive = in_words_of(joined.axis, EXCITING_MANOEUVRE)
    by_others = not idle and terms.coupled is None
    pushed = coupling_sentence(joined, training.samples, training.signals) if by_others else None
    besides = (
        "" if pushed is None else f"; or other velocities caused it: {pushed}; {cure('other velocities', joined.axis)}"
    )
    doubted = next((each.findings[0] for each in verdicts if each.findings), None)
    why = f"too little motion to learn from: {made}; {drive}"
    if doubted is not None and not little:
        why = f"no samples are usable: {with_cure(doubted, runs[0])}"
    raise BadInput(f"{joined.name}: {why}{besides}")


MIN_GAIN_SHARE = 0.03
"""Part of the free run's error by which it must fall before other settings are better: less is chance."""
AS_GIVEN = frozenset((SMOOTHING, TORQUE_KIND))
"""The settings of which alternatives are tried, where none is to be replaced."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """Signal settings that were tried.

    Attributes:
        setting: the one that differs.
        training: the course with them.
        error: of the free run with them [rad/s].
        share: by how much the curve may still be off, as a part of it.
    """

    setting: str
    training: Training
    error: float
    share: float


def alternative(
    quick: ResolutionFault,
    runs: Sequence[Recording],
    unseen: Sequence[Recording],
    terms: Terms,
    training: Training,
    in_force: frozenset[str],
) -> tuple[str | None, Alternative | None]:
    """The remark on motion that is faster than the samples show, if it leaves anything to do, and what to go on with.

    Args:
        runs: what was learned from.
        unseen: what decides; without them those learned from do.
        training: what is in force.
        in_force: settings that are alternatives already.
    """
    signals, judged_on = training.signals, unseen or runs
    before = terms.free_run(judged_on, signals, training.model)
    others = [other for other in _others(quick, runs, signals, terms) if other[0] not in in_force]
    better = list[Alternative]()
    with progress("trying other signal settings", len(others)) as advance:
        for setting, other in others:
            found = _tried(setting, runs, unseen, terms, other)
            enough = found is not None and (before is None or found.error <= (1.0 - MIN_GAIN_SHARE) * before)
            if found is not None and enough:
                better.append(found)
            advance()
    axis, words = runs[0].axis, words_of(runs[0].axis)
    if not better:
        faster = None if in_force else quick.faster(signals)
        return (None if faster is None else in_words_of(axis, f"{quick.sentence}; record {faster}")), None
    best = min(better, key=lambda each: (each.setting in terms.by_person, each.error))
    was = "runs away" if before is None else f"is {before:.3g} {words.rate_unit}"
    still = f"may still be {100.0 * best.share:.0f} % wrong" if best.share > 0.0 else "is then right within 10 %"
    name = sequence(judged_on).name
    gain = (
        f"the free run's error on {name} {was} without and {best.error:.3g} {words.rate_unit} with it, and the curve "
        f"{still}"
    )
    if best.setting in terms.by_person:
        mends = cure(
            "smoothing" if best.setting == SMOOTHING else "command", axis, width=best.training.signals.smoothing
        )
        return in_words_of(axis, f"{quick.sentence}; {mends}: {gain}"), None
    seen = "" if judged_on is runs else f"; {name} decided it, and is no longer quite unseen"
    return in_words_of(axis, f"{_used(best, signals, words.effort)}: {gain}{seen}"), best


def _used(best: Alternative, before: SignalSettings, effort: str) -> str:
    """The words for the use of an alternative in place of what was before."""
    if best.setting == SMOOTHING:
        width = best.training.signals.smoothing
        return f"smoothing over {width:g} s is used, because {before.smoothing:.2g} s is too slow"
    return f"the {effort} is used as a command, constant until the next, not as a measurement"


def _others(
    quick: ResolutionFault, runs: Sequence[Recording], signals: SignalSettings, terms: Terms
) -> list[tuple[str, SignalSettings]]:
    """The settings that may mend it, each with the name of the one that differs."""
    found = list[tuple[str, SignalSettings]]()
    width = None if quick.late else quick.narrower(signals)
    if width is not None:
        found.append((SMOOTHING, with_smoothing(signals, width)))
    if signals.torque != COMMANDED and terms.learner is not None:
        found.append((TORQUE_KIND, replace(signals, torque=COMMANDED)))
    elif signals.torque != COMMANDED:
        found.append((TORQUE_KIND, terms.scaled(runs, signals, COMMANDED)))
    return found


def _tried(
    setting: str, runs: Sequence[Recording], unseen: Sequence[Recording], terms: Terms, other: SignalSettings
) -> Alternative | None:
    """The result of other settings; None if they give too few samples, or the model diverges."""
    try:
        with without_bars():
            training = _training(runs, unseen, other, terms)
    except BadInput:
        return None
    if not training.iterations or not training.model.is_trained:
        return None
    error = terms.free_run(unseen or runs, other, training.model)
    left = resolution_fault(training.samples, other.smoothing)
    return None if error is None else Alternative(setting, training, error, 0.0 if left is None else left.share)
