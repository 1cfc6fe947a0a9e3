"""What to drive next: the shortest manoeuvre that separates two explanations, found by simulating it under both.

Under each candidate manoeuvre the found model moves without noise; the alternative then explains that motion as well as
it can, all its parameters free. What it leaves, whitened as the recordings' noise, is the evidence to expect (the
noncentrality of the likelihood ratio; F. Pukelsheim, Optimal Design of Experiments, 2006, ch. 1).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, groupby

import numpy as np

from incsvr.effects import Signals
from incsvr.errors import BadInput
from incsvr.tracing.model import TracedModel
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.command import as_given
from incsvr.tracing.weak.hypothesis import Hypothesis, settle
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.posing import pose_like
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.whitening import whiten

ENOUGH = 20.0
"""Expected 2 Δℓ with which a manoeuvre is worth driving."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A command in yaw.

    Attributes:
        words: what to drive.
        torque: (n,) on the problem's grid [N m].
    """

    words: str
    torque: Array


def manoeuvres(problem: Problem) -> Iterator[Manoeuvre]:
    """Candidates within the torque that the recordings held, shortest first."""
    s = problem.signals
    top = float(np.quantile(np.abs(s.torque), 0.98))
    for scales in (12.0, 24.0, 48.0):
        length = scales * s.scale
        t = np.arange(0.0, length, s.step)
        for level in (1.0, 0.5):
            for period in (2.0, 4.0, 8.0):
                p = period * s.scale
                yield Manoeuvre(
                    f"a sine of {level * top:.3g} N m and {p:.3g} s for {length:.0f} s",
                    level * top * np.sin(2.0 * np.pi * t / p),
                )
                yield Manoeuvre(
                    f"steps between ±{level * top:.3g} N m every {p / 2.0:.3g} s for {length:.0f} s",
                    level * top * np.where(np.mod(t, p) < p / 2.0, 1.0, -1.0),
                )
        stairs = np.array([0.25, 0.0, -0.25, 0.5, 0.0, -0.5, 1.0, 0.0, -1.0, 0.75, 0.1, -0.75, -0.1])
        hold = length / stairs.size
        yield Manoeuvre(
            f"stairs of 25, 50, 75 and 100 % of {top:.3g} N m both ways, with rests, {hold:.3g} s each",
            top * stairs[np.minimum((t / hold).astype(int), stairs.size - 1)],
        )
        sweep = 0.5 * t**2 / length * (2.0 / s.scale - 0.05 / s.scale) + 0.05 / s.scale * t
        yield Manoeuvre(
            f"a sweep of {top:.3g} N m from {20.0 * s.scale:.3g} s to {0.5 * s.scale:.3g} s period in {length:.0f} s",
            top * np.sin(2.0 * np.pi * sweep),
        )


def separate(problem: Problem, found: Hypothesis, alternative: Hypothesis, other: str) -> str:
    """A sentence with the shortest manoeuvre that tells `found` from `alternative`, or that there is none."""
    if float(np.ptp(problem.signals.torque)) == 0.0:
        return f"to tell it from {other}, let the thrusters turn the vehicle: here they stood still"
    model = model_of(problem, found)
    *shorter, longest = ([*alike] for _, alike in groupby(manoeuvres(problem), lambda each: each.torque.size))
    driven = _driven(problem, model, longest)
    *_, richest = driven  # if not even that tells them apart, none of the others does
    most, best = _evidence(problem, model, found, alternative, richest, 0.0), richest
    if most < 1.0:
        return (
            f"no manoeuvre in yaw tells it from {other}: both explain every motion alike; measure one of the two by "
            "other means (a bollard pull, a pendulum test)"
        )
    for run in chain((run for alike in shorter for run in _driven(problem, model, alike)), driven):
        expected = most if run is richest else _evidence(problem, model, found, alternative, run, most)
        if expected >= ENOUGH:
            return (
                f"to tell it from {other}, drive {run.name}{_with_channels(found, alternative)}: "
                f"expected evidence 2Δℓ ≈ {expected:.0f}"
            )
        if expected > most:
            best, most = run, expected
    return f"to tell it from {other}, drive {best.name}, several times: expected evidence 2Δℓ ≈ {most:.1f} each"


def _with_channels(found: Hypothesis, alternative: Hypothesis) -> str:
    effects = (*found.effects, *alternative.effects)
    read = sorted({channel for effect in effects for channel in effect.channels})
    return f" while {', '.join(read)} sweeps its range" if read else ""


def _driven(problem: Problem, model: TracedModel, alike: Sequence[Manoeuvre]) -> list[Run]:
    """Manoeuvres of one length as the model drives them, side by side: it is calls that cost."""
    s = problem.signals
    n = alike[0].torque.size
    time = np.asarray(s.origin[1] + s.step * np.arange(n), dtype=np.float64)
    channels = {}
    for k, (name, values) in enumerate(sorted(s.channels.items())):
        low, high = (float(q) for q in np.quantile(values, [0.02, 0.98]))
        phase = 2.0 * np.pi * np.arange(n) / n * (1.37 + 0.61 * k)
        channels[name] = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(phase)
    every, still = len(alike), np.zeros(n * len(alike))
    start = Signals(
        step=s.step, start=n * np.arange(every + 1), time=np.tile(time, every), rate=still, heading=still,
        torque=np.concatenate([each.torque for each in alike]),
        channels={name: np.tile(values, every) for name, values in channels.items()},
    )  # fmt: skip
    _, rate = model.simulate(start, s.step)
    heading = start.integral(rate)
    return [
        Run(each.words, time, yaw_rate, each.torque, {**channels, "heading": to})
        for each, yaw_rate, to in zip(alike, rate.reshape(every, n), heading.reshape(every, n), strict=True)
    ]


def _evidence(
    problem: Problem, model: TracedModel, found: Hypothesis, alternative: Hypothesis, run: Run, least: float
) -> float:
    """Expected evidence of a manoeuvre; of one that cannot reach the `least`, no more than that."""
    if float(np.max(np.abs(run.yaw_rate))) > 1.3 * float(np.max(np.abs(model.rate))):
        return 0.0
    try:
        driven = pose_like(problem, [run], as_given)
        driven = replace(driven, signals=replace(driven.signals, torque_noise_fraction=0.0))  # this torque has no noise
    except BadInput:
        return 0.0
    missed = _left(driven, alternative, found)
    if missed <= least:
        return missed
    own = _left(driven, found, found)  # nothing but the error of integration: half of it again is no evidence
    return max(missed - 1.5 * own, 0.0)


def _left(driven: Problem, hypothesis: Hypothesis, noise: Hypothesis) -> float:
    """What a hypothesis leaves of a noiseless motion, all its parameters free, in squared innovations of the noise."""
    terms = hypothesis.values()
    settled = settle(
        driven, terms, _noiseless(driven, hypothesis), frozenset(e.key for e in hypothesis.effects), passes=4
    )
    y = driven.y - sum(settled.offsets, np.zeros(driven.y.size))
    x = whiten(settled.columns, noise.fit.ar, driven.blocks) / noise.fit.scale
    z = whiten(y, noise.fit.ar, driven.blocks) / noise.fit.scale
    theta = np.linalg.lstsq(x, z, rcond=1e-10)[0]
    return float(np.sum((z - x @ theta) ** 2))


def _noiseless(driven: Problem, hypothesis: Hypothesis) -> Hypothesis:
    """The hypothesis with nothing left over yet, as a start on another run."""
    zero = np.zeros(len(driven.signals))
    fitted = replace(
        hypothesis.fit, residual=np.zeros(len(driven.blocks)), weight=np.ones(driven.blocks.with_history.size)
    )
    return replace(hypothesis, fit=fitted, losses=tuple(zero for _ in hypothesis.terms))
