"""The refusals of recordings that teach too little, each one sentence with its cure."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.checks import YOUNG_CURVE_BATCHES, Verdict
from incsvr.errors import BadInput
from incsvr.learning.excitation import EXCITING_MANOEUVRE, Excitation
from incsvr.learning.model import Model
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, MEASURED
from service.commands import other_velocities
from service.commands.cures import Cures
from service.commands.fit_attempt import Terms
from service.recordings.recording import Recording, sequence


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
    return because or BadInput(
        f"{sequence(runs).name}: {count} damping samples, but one batch needs {batch}; give more or longer "
        f"recordings (a sample every {signals.sample_period:g} s)"
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
