"""Other signal settings for recordings whose motion is quicker than the samples show: tried, and in force where they
are better and nobody set others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from incsvr.checks.resolution import ResolutionFault, resolution_fault
from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.words import words_of
from incsvr.signals import SignalSettings
from incsvr.signals.settings import COMMANDED
from service.cli.progress import progress
from service.fitting.terms import SMOOTHING, TORQUE_KIND, Terms
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import with_smoothing

MIN_GAIN_SHARE = 0.03
"""Part of the free run's error by which it must fall before other settings are better: less is chance."""
AS_GIVEN = frozenset((SMOOTHING, TORQUE_KIND))
"""The settings of which alternatives are tried, where none is to be replaced."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """Signal settings that were tried.

    Attributes:
        setting: the one that differs.
        signals: all of them.
        error: of the free run with them [rad/s].
        share: by how much the curve may still be off, as a part of it.
    """

    setting: str
    signals: SignalSettings
    error: float
    share: float


def alternative(
    quick: ResolutionFault,
    runs: Sequence[Recording],
    judged_on: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    model: Model,
    in_force: frozenset[str],
) -> tuple[str | None, Alternative | None]:
    """The remark on motion that is faster than the samples show, if it leaves anything to do, and what to go on with.

    Args:
        runs: what was learned from.
        judged_on: what decides: the unseen recordings, or those learned from where there are none.
        signals, model: what is in force.
        in_force: settings that are alternatives already.
    """
    before = terms.free_run(judged_on, signals, model)
    others = [other for other in _others(quick, runs, signals, terms) if other[0] not in in_force]
    better = list[Alternative]()
    with progress("trying other signal settings", len(others)) as advance:
        for setting, other in others:
            found = _tried(setting, runs, judged_on, signals, terms, other)
            enough = found is not None and (before is None or found.error <= (1.0 - MIN_GAIN_SHARE) * before)
            if found is not None and enough and found.share < quick.share:
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
    flag, used = _named(best, signals, words.effort)
    if best.setting in terms.by_person:
        return in_words_of(axis, f"{quick.sentence}; give {flag}: {gain}"), None
    seen = "" if judged_on is runs else f"; {name} decided it, and is no longer quite unseen"
    return in_words_of(axis, f"{used}: {gain}{seen}"), best


def _named(best: Alternative, before: SignalSettings, effort: str) -> tuple[str, str]:
    """The flag that sets an alternative, and the words for its use in place of what was before."""
    if best.setting == SMOOTHING:
        width = f"{best.signals.smoothing:g}"
        return (
            f"--set signals.smoothing={width}",
            f"smoothing over {width} s is used, because {before.smoothing:.2g} s is too slow",
        )
    used = f"the {effort} is used as a command, constant until the next, not as a measurement"
    return f"--set signals.torque={COMMANDED}", used


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
    setting: str,
    runs: Sequence[Recording],
    judged_on: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    other: SignalSettings,
) -> Alternative | None:
    """The result of other settings; None if they give too few samples, or the model diverges."""
    joined = sequence(runs)
    try:
        samples, _ = terms.samples(joined, other)
        _, iterations, _ = terms.learned(samples, other, terms.settings(joined, samples))
    except BadInput:
        return None
    if not iterations or not iterations[-1].model.is_trained:
        return None
    error = terms.free_run(judged_on, signals, iterations[-1].model)
    left = resolution_fault(samples, other.smoothing)
    return None if error is None else Alternative(setting, other, error, 0.0 if left is None else left.share)
