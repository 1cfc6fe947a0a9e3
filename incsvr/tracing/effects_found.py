"""The effects of an identification as findings in the contract's words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.model.candidates import Candidate, joined, without
from incsvr.model.efforts import Stage
from incsvr.model.fitting import Fit, fit
from incsvr.model.identification import EFFECTS, PLAIN, Identification
from incsvr.model.intervals import halved
from incsvr.model.rows import Row
from incsvr.model.search import Added, is_noise
from incsvr.model.series import effort_of, period, values
from incsvr.plant.axes import of_rate
from incsvr.plant.words import AxisWords, words_of
from incsvr.tracing.answering import Loop
from incsvr.tracing.findings import Finding
from incsvr.tracing.parameters import parameters_of
from incsvr.tracing.recordings import Recordings
from incsvr.tracing.sentences import AHEAD, LABELS
from incsvr.tracing.statistics import p_value
from incsvr.tracing.unseen import Judge
from incsvr.tracing.vocabulary import contract_name, streams, word_of

ROUND_NUMBERS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Commands at which people read a thrust, in their decade."""
FREE = ", free inertia"
"""The end of the names of simulators whose inertia is free."""
CURVES = ("dead", "gap", "limit", "sag", "reverse", "exponent")
"""Stages of the effort that are a curve of the command."""

Shape = tuple[str, tuple[float, float]]
"""A stage, and the ends of the interval of its size."""


@dataclass(frozen=True)
class Traced:
    """What a result is made of.

    Attributes:
        found: the identification.
        recordings: that it was fitted to.
        fitted, unseen: judges by them, and by data that no fit used.
        inertia: declared [kg], [kg m²].
        loop: how the torque follows the rate.
    """

    found: Identification
    recordings: Recordings
    fitted: Judge
    unseen: Judge
    inertia: float
    loop: Loop

    @property
    def closed(self) -> bool:
        """Whether the torque answers the rate."""
        return self.loop is not Loop.OPEN

    @property
    def words(self) -> AxisWords:
        """The words of the axis."""
        return words_of(of_rate(self.recordings.axis))

    @property
    def sample(self) -> float:
        """The usual time between two samples of the velocity [s]."""
        return period(self.recordings.streams, self.recordings.axis)

    def least_band(
        self,
        share: float = 0.03,  # of the largest effort, as of a thrust: narrower ones gain from slow drag that is inexact
        deviations: float = 2.0,  # of the effort's noise: a narrower band takes that noise away
    ) -> float:
        """The half width from which a dead band has a size [N], [N m]."""
        axis = self.recordings.axis
        effort = effort_of(axis)
        noise = (1.0 - self.found.reliability.get(axis, 1.0)) * np.var(values(self.recordings.streams, effort))
        return max(share * self.found.found.fit.problem.windows.largest(effort), deviations * math.sqrt(noise))


def findings_of(traced: Traced, free_inertia: bool) -> tuple[str, list[Finding]]:
    """The simulator with what was found, by its name, and the effects in the order in which they were added.

    Their sizes are those of the simulator, in closed loop of the predictor.

    Args:
        free_inertia: whether an inertia may be one that the search did not add.
    """
    found, axis = traced.found, traced.recordings.axis
    added, predictor = found.found.added, found.found.fit
    name = EFFECTS if added else PLAIN
    freed = _with_free_inertia(traced, name) if free_inertia and not traced.closed else None
    gains = {each.name: each.gain for each in added}
    if freed is not None:
        gains[f"inertia@{axis}"] = predictor.value - freed.value
        name, predictor = f"{name}{FREE}", freed
    if not gains:
        return PLAIN, []
    source = predictor if traced.closed else found.models[name]
    others = [halved(source)] if traced.closed else [halved(source), predictor]
    late = 0.5 * period(traced.recordings.streams, effort_of(axis)) if found.reliability[axis] < 1.0 else 0.0
    every = parameters_of(source, list(gains), traced.inertia, traced.recordings.begin, others, late)
    total = sum(gains.values())
    shapes = {each.name: _in_other_shape(traced, source, each, each.other) for each in added if each.other is not None}
    alike = {each.name: [one for one in each.alike if not _contains(found.effects, one, each)] for each in added}
    counts = {each.name: len(each.candidate.start) for each in added}
    return name, [
        _finding(
            traced, one, parameters, spans, p_value(2.0 * gain, counts.get(one, 1), len(found.effects)),
            gain / total, alike.get(one, ()), shapes.get(one),
        )
        for (one, gain), (parameters, spans) in zip(gains.items(), every, strict=True)
    ]  # fmt: skip


def _with_free_inertia(
    traced: Traced,
    name: str,
    least: float = 0.03,  # of the error of excluded free runs: a reader would not see less
    clear: float = 6.0,  # of the logarithm of the predictor's likelihood: 1 of 2000 by chance
) -> Fit | None:
    """The predictor with a free inertia, where that is an effect which the search did not add: in open loop, where the
    simulator with it is clearly better on excluded recordings, and the predictor is better with it."""
    found, axis = traced.found, traced.recordings.axis
    free = f"{name}{FREE}"
    errors = {each: float(excluded[0]) for each, excluded in found.excluded.items()}
    if free not in found.models or is_noise(found.reliability, axis) or errors[free] > (1.0 - least) * errors[name]:
        return None
    mass, predictor = f"mass:{axis}", found.found.fit
    start = {mass: found.models[free].theta[mass], **predictor.theta}
    freed = fit(predictor.structure.plus(free=[axis]), start, predictor.problem, predictor.starts)
    return freed if predictor.value - freed.value > clear else None


def _finding(
    traced: Traced, name: str, parameters: dict[str, float], spans: dict[str, tuple[float, float]], chance: float,
    share: float, alike: Sequence[str], other: Shape | None,
) -> Finding:  # fmt: skip
    named, words = dict.fromkeys(contract_name(each) for each in alike), traced.words
    others = tuple(each for each in named if each != contract_name(name))
    return Finding(
        effect=contract_name(name),
        channels=streams(name),
        parameters=parameters,
        interval=spans,
        p_value=chance,
        share=share,
        cannot_tell_from=(*others, *word_of(name).ties),
        next_manoeuvre=next_manoeuvre(name, others, words),
        sentence=sentence(name, parameters, spans, share, words),
        thrust=_thrust(name, parameters, spans, traced.found.models[PLAIN], other),
        shape=word_of(name).shape,
    )


def _contains(effects: Mapping[str, Sequence[Row]], name: str, added: Added) -> bool:
    """Whether an effect is the added one with more rows, which explains the recordings as well in any case."""
    rows = effects.get(name, effects.get(name.partition("@")[0], ()))
    return set(added.candidate.start) <= {row.key for row in rows}


def next_manoeuvre(name: str, others: Sequence[str], words: AxisWords) -> str:
    """What a log must show to distinguish an effect from the others that explain this one as well, or that none can."""
    word = word_of(name)
    if others:
        return f"to distinguish it from {others[0]}, the log must show {words.fill(word.shown_by)}"
    if word.ties:
        return (
            f"no manoeuvre in {words.name} distinguishes it from {word.ties[0]}: both explain every motion alike; "
            f"{word.apart}"
        )
    return ""


def sentence(
    name: str,
    parameters: Mapping[str, float],
    spans: Mapping[str, tuple[float, float]],
    share: float,
    words: AxisWords,
) -> str:
    """The sentence of a finding: its values with 95 % intervals, and its share of the better fit."""
    shown = []
    for key, value in parameters.items():
        label, unit = (words.fill(each) for each in LABELS[key])
        low, high = spans[key]
        spread = f" ({low:.3g} to {high:.3g})" if high > low else ""
        shown.append(f"{label} {value:.3g}{spread}{' ' + unit if unit else ''}")
    meaning = words.fill(AHEAD if parameters.get("delay_s", 0.0) < 0.0 else word_of(name).sentence)
    part = f"It accounts for {100.0 * share:.0f} % of the better fit."
    return f"{contract_name(name)}: {meaning}; {', '.join(shown)}. {part}"


def _in_other_shape(traced: Traced, source: Fit, added: Added, other: Candidate) -> Shape:
    """The stage that is an effect in its other shape, and the interval of 95 % of its size."""
    structure = joined(without(source.structure, added.candidate, traced.found.base.structure), other)
    found = fit(structure, {**source.theta, **other.start}, source.problem, source.starts)
    ((_, spans),) = parameters_of(found, [other.name], traced.inertia, traced.recordings.begin)
    (span,) = spans.values()
    return other.name.partition("@")[0], span


def _thrust(
    name: str,
    parameters: Mapping[str, float],
    spans: Mapping[str, tuple[float, float]],
    source: Fit,
    other: Shape | None,
    count: int = 21,  # commands a tenth of the largest apart
) -> tuple[tuple[float, float, float, float], ...]:
    """The thrust that a curve makes of commands up to the largest either way, rounded up, with its interval [N m].

    It is empty for effects that are no curve of the command. Where an effect has another shape the interval contains
    that, too.
    """
    kind, _, axis = name.partition("@")
    if kind not in CURVES:
        return ()
    top = source.problem.windows.largest(effort_of(axis))
    decade = 10.0 ** math.floor(math.log10(top))
    full = next(number * decade for number in ROUND_NUMBERS if number * decade >= top)
    ((key, value),) = parameters.items()
    shapes: list[tuple[str, Sequence[float]]] = [(kind, (value, *spans[key]))]
    shapes += [] if other is None else [other]
    commands = np.linspace(-full, full, count)
    made = np.array([Stage(**{stage: each}).static(commands, top) for stage, sizes in shapes for each in sizes])
    rows = np.column_stack((commands, made[0], made[1:].min(axis=0), made[1:].max(axis=0)))
    return tuple((command, thrust, low, high) for command, thrust, low, high in rows.tolist())
