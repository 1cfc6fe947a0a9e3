"""The effects of an identification as findings in the contract's words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.fitting import Fit, fit
from incsvr.model.identification import Identification
from incsvr.model.intervals import halved
from incsvr.model.rows import Row
from incsvr.model.search import Added
from incsvr.model.series import effort_of, period
from incsvr.model_trace.answering import Loop
from incsvr.model_trace.findings import Finding
from incsvr.model_trace.parameters import has_size, parameters_of
from incsvr.model_trace.proof import EFFECTS, PLAIN
from incsvr.model_trace.recordings import Recordings
from incsvr.model_trace.sentences import AHEAD, LABELS
from incsvr.model_trace.statistics import p_value
from incsvr.model_trace.unseen import Judge
from incsvr.model_trace.vocabulary import contract_name, streams, word_of
from incsvr.plant.axes import of_rate
from incsvr.plant.words import AxisWords, words_of

ROUND_NUMBERS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Commands at which people read a thrust, in their decade."""
FREE = ", free inertia"
"""What the name of a simulator ends with whose inertia is free though it is declared."""
CURVES = {"dead": "dead", "limit": "limit", "reverse": "reverse", "exponent": "exponent"}
"""Stages of the effort that are a curve of the command."""


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


def best_model(
    traced: Traced,
    least: float = 0.03,  # of the error of excluded free runs: a reader would not see less
) -> tuple[str, list[Finding], list[Finding]]:
    """The best of our own simulators on excluded recordings, its effects, and those whose size the recordings hide.

    A free inertia that the search did not add is one in open loop alone, where a simulation with it is clearly better
    and the predictor agrees that it is another than the declared.
    """
    found = traced.found
    errors = {name: float(each[0]) for name, each in found.excluded.items()}
    names = [PLAIN, *([EFFECTS] if found.found.added else [])]
    free = [] if traced.closed else [f"{name}{FREE}" for name in names if f"{name}{FREE}" in found.models]
    needed = {name: errors[name] for name in names} | {name: errors[name] / (1.0 - least) for name in free}
    for name in sorted(names + free, key=needed.__getitem__):
        predictor = _freed(traced, name) if name in free else found.found.fit
        of_inertia = found.models[name.removesuffix(FREE)].value - found.models[name].value
        added = findings_of(traced, name, predictor, of_inertia)
        sized = [each for each in added if has_size(each.interval, traced.inertia, traced.sample)]
        unsure = [each for each in added if each not in sized]
        inertia = _inertia(traced, name, predictor, of_inertia) if name in free else []
        if (sized or not name.startswith(EFFECTS)) and (inertia or name not in free):
            return name, sized + inertia, unsure
    raise AssertionError("the plain model is always one")


def _freed(traced: Traced, name: str) -> Fit:
    """The predictor with a free inertia, from that of a simulator."""
    axis, predictor = traced.recordings.axis, traced.found.found.fit
    start = {f"mass:{axis}": traced.found.models[name].theta[f"mass:{axis}"], **predictor.theta}
    return fit(predictor.structure.plus(free=[axis]), start, predictor.problem, predictor.starts)


def _inertia(traced: Traced, name: str, predictor: Fit, gain: float) -> list[Finding]:
    """The free inertia of a simulator as an effect, where it is surely another than the declared one."""
    found, model = traced.found, traced.found.models[name]
    effect, others = f"inertia@{traced.recordings.axis}", [halved(model), predictor]
    ((parameters, spans),) = parameters_of(model, [effect], traced.inertia, traced.recordings.begin, others)
    if not has_size(spans, traced.inertia, traced.sample):
        return []
    beside = sum(each.gain for each in found.found.added) if name.startswith(EFFECTS) else 0.0
    p, share = p_value(2.0 * gain, 1, len(found.effects)), gain / (gain + beside)
    return [_finding(traced, effect, parameters, spans, p, share, ())]


def findings_of(traced: Traced, name: str, predictor: Fit, beside: float) -> list[Finding]:
    """The effects in the order in which they were added: by a simulator that has them, in closed loop by the
    predictor; `beside` is the gain of a free inertia."""
    found, recordings = traced.found, traced.recordings
    added = found.found.added
    if not added:
        return []
    source = predictor if traced.closed else found.models[name if name.startswith(EFFECTS) else EFFECTS]
    others = [halved(source)] if traced.closed else [halved(source), predictor]
    every = parameters_of(source, [each.name for each in added], traced.inertia, recordings.begin, others)
    total = beside + sum(each.gain for each in added)
    findings = []
    for one, (parameters, spans) in zip(added, every, strict=True):
        alike = [other for other in one.alike if not _contains(found.effects, other, one)]
        p = p_value(2.0 * one.gain, len(one.candidate.start), len(found.effects))
        findings.append(_finding(traced, one.name, parameters, spans, p, one.gain / total, alike))
    return findings


def _finding(
    traced: Traced, name: str, parameters: dict[str, float], spans: dict[str, tuple[float, float]], chance: float,
    share: float, alike: Sequence[str],
) -> Finding:  # fmt: skip
    others, words = tuple(dict.fromkeys(contract_name(each) for each in alike)), traced.words
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
        thrust=_thrust(name, parameters, spans, traced.found.models[PLAIN]),
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


def _thrust(
    name: str, parameters: Mapping[str, float], spans: Mapping[str, tuple[float, float]], source: Fit
) -> tuple[tuple[float, float, float, float], ...]:
    """Of a curve of the command: at the largest command either way, rounded up, the thrust with its interval [N m]."""
    kind, _, axis = name.partition("@")
    if kind not in CURVES:
        return ()
    top = source.problem.windows.largest(effort_of(axis))
    decade = 10.0 ** math.floor(math.log10(top))
    full = next(number * decade for number in ROUND_NUMBERS if number * decade >= top)
    ((key, value),) = parameters.items()
    found = []
    for command in (-full, full):
        made = [
            float(Stage(**{CURVES[kind]: each}).static(np.array([command]), top)[0]) for each in (value, *spans[key])
        ]
        found.append((command, made[0], min(made[1:]), max(made[1:])))
    return tuple(found)
