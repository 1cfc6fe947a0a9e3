"""Other signal settings for recordings whose motion is quicker than the samples show: tried before any is proposed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from incsvr.checks.resolution import ResolutionFault, resolution_fault
from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.plant.words import words_of
from incsvr.signals import SignalSettings
from incsvr.signals.settings import COMMANDED, TorqueKind
from service.cli.progress import progress
from service.commands.fit_attempt import Terms
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import signals_for, with_smoothing

MIN_GAIN_SHARE = 0.03
"""Part of the free run's error by which it must fall before other settings are proposed: less is chance."""


@dataclass(frozen=True, slots=True)
class _Gain:
    """The gain of other settings.

    Attributes:
        flag: what sets them.
        error: of the free run with them [rad/s].
        share: by how much the curve may still be off, as a part of it.
    """

    flag: str
    error: float
    share: float


def proposal(
    quick: ResolutionFault,
    runs: Sequence[Recording],
    judged_on: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    model: Model,
) -> str:
    """The remark on settings for motion that is faster than the samples show: their gain, or that none gains.

    Args:
        runs: what was learned from.
        judged_on: the unseen recordings, or those learned from where there are none.
        signals, model: what is in force.
    """
    before = terms.free_run(judged_on, signals, model)
    tried, gains = [], list[_Gain]()
    flags = _flags(quick, signals)
    with progress("trying other signal settings", len(flags)) as advance:
        for flag, smoothing, torque in flags:
            tried.append(flag)
            found = _tried(flag, runs, judged_on, signals, terms, smoothing, torque)
            if found is not None and found.share < quick.share:
                gains.append(found)
            advance()
    name = sequence(judged_on).name
    best = min(gains, key=lambda gain: gain.error, default=None)
    if best is None or (before is not None and best.error > (1.0 - MIN_GAIN_SHARE) * before):
        return f"tried without gain: {', '.join(tried)}" if tried else "the streams are too slow for a narrower filter"
    was = "ran away" if before is None else f"was {before:.3g}"
    still = f"may still be off by {100.0 * best.share:.0f} %" if best.share > 0.0 else "is then right within 10 %"
    unit = words_of(runs[0].axis).rate_unit
    return (
        f"give {best.flag}: tried on {name}, the free run's error is {best.error:.3g} {unit} with it and {was} "
        f"without, and the curve {still}"
    )


def _flags(quick: ResolutionFault, signals: SignalSettings) -> list[tuple[str, float | None, TorqueKind | None]]:
    """The flags that may mend it, with the filter's width [s] and the kind of torque that each sets."""
    flags: list[tuple[str, float | None, TorqueKind | None]] = []
    width = None if quick.late else quick.narrower(signals)
    if width is not None:
        flags.append((f"--smoothing {width:g}", width, signals.torque))
    if signals.torque != COMMANDED:
        flags.append((f"--torque {COMMANDED}", None, COMMANDED))
    return flags


def _tried(
    flag: str,
    runs: Sequence[Recording],
    judged_on: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    smoothing: float | None,
    torque: TorqueKind | None,
) -> _Gain | None:
    """The result of other settings; None if they give too few samples, or the model diverges."""
    joined = sequence(runs)
    try:
        other = _with(signals, runs, terms, smoothing, torque)
        samples, _ = terms.samples(joined, other)
        settings = terms.settings(joined, samples)
        _, iterations = terms.learned(samples, other, settings)
    except BadInput:
        return None
    if not iterations or not iterations[-1].model.is_trained:
        return None
    error = terms.free_run(judged_on, signals, iterations[-1].model)
    left = resolution_fault(samples, other.smoothing)
    return None if error is None else _Gain(flag, error, 0.0 if left is None else left.share)


def _with(
    signals: SignalSettings, runs: Sequence[Recording], terms: Terms, smoothing: float | None, torque: TorqueKind | None
) -> SignalSettings:
    """The settings that `fit` would have with --smoothing or --torque beside the same configuration."""
    if torque == signals.torque:
        other = signals
    elif terms.learner is not None:
        other = replace(signals, torque=torque)
    else:
        scaled = signals_for(runs, signals.inertia, signals.rate_limit, torque)
        other = replace(scaled, channels=signals.channels)
    return other if smoothing is None else with_smoothing(other, smoothing)
