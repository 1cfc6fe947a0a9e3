"""What these recordings cannot tell from an effect that was found, and what to drive to tell it: both computed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals, ThrustEfficiency
from incsvr.tracing.forward.fit import Fit, fit
from incsvr.tracing.forward.grid import Grid, in_blocks
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.search import objection, scan, settled, without
from incsvr.tracing.forward.thresholds import INDISTINGUISHABLE
from incsvr.tracing.model import TracedModel
from incsvr.tracing.run import Run

Array = NDArray[np.float64]

TRIED = 5
"""Alternatives that are fitted in full."""

ENOUGH = 20.0
"""Expected 2 Δℓ with which a manoeuvre is worth driving."""

LONGEST = 20_000
"""Cells of a manoeuvre that is tried."""


def indistinguishable(question: Question, best: Fit, k: int) -> tuple[Fit, ...]:
    """The fits that explain the recordings as well with another effect, its last, in the k-th one's place."""
    reduced, part = without(question.grid, best, k), best.parts[k]
    every = question
    if "inertia" not in reduced.names():
        # beside an inertia a thrust efficiency has nothing of its own: the two and the damping are one equation
        every = Question.of(question.grid, [*question.effects, ThrustEfficiency()], best)
    found, seen = list[Fit](), set[str]()
    for lead in [lead for lead in scan(every, reduced) if lead.part.name != part.name][:TRIED]:
        tried = settled(question.grid, reduced, lead.part)
        deficit = 2.0 * (best.log_likelihood - tried.log_likelihood) + every.price(lead.part) - question.price(part)
        if deficit < INDISTINGUISHABLE and not objection(question.grid, tried, len(tried.parts) - 1):
            if lead.part.name not in seen:
                found.append(tried)
            seen.add(lead.part.name)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A command in yaw: what to drive, in words, and the torque (n,) [N m]."""

    words: str
    torque: Array


def separate(grid: Grid, model: TracedModel, found: Fit, alternative: Fit) -> str:
    """A sentence with the shortest manoeuvre that tells `found` from `alternative`, or that there is none.

    Under each manoeuvre the found model moves without noise; the alternative explains that motion as well as it can,
    all its coefficients free. What it leaves, whitened as the recordings' noise, is the evidence to expect (the
    noncentrality of the likelihood ratio; F. Pukelsheim, Optimal Design of Experiments, 2006, ch. 1).
    """
    other = alternative.parts[-1].name
    if float(np.ptp(grid.signals.torque)) == 0.0:
        return f"to tell it from {other}, let the thrusters turn the vehicle: here they stood still"
    most, best = 0.0, ""
    for manoeuvre in _manoeuvres(grid):
        evidence = _evidence(grid, model, found, alternative, manoeuvre)
        if evidence >= ENOUGH:
            with_channels = sorted({c for part in (*found.parts, *alternative.parts) for c in part.effect.channels})
            beside = f" while {', '.join(with_channels)} sweeps its range" if with_channels else ""
            return f"to tell it from {other}, drive {manoeuvre.words}{beside}: expected evidence 2Δℓ ≈ {evidence:.0f}"
        if evidence > most:
            most, best = evidence, manoeuvre.words
    if most < 1.0:
        return (
            f"no manoeuvre in yaw that was tried tells it from {other}: both explain the motion alike; measure one of "
            "the two by other means (a bollard pull, a pendulum test)"
        )
    return f"to tell it from {other}, drive {best}, several times: expected evidence 2Δℓ ≈ {most:.1f} each"


def _manoeuvres(grid: Grid) -> Iterator[Manoeuvre]:
    """Candidates within the torque that the recordings held, shortest first."""
    s = grid.signals
    top, step = float(np.quantile(np.abs(s.torque), 0.98)), grid.resolution
    stairs = np.array([0.25, 0.0, -0.25, 0.5, 0.0, -0.5, 1.0, 0.0, -1.0, 0.75, 0.1, -0.75, -0.1])
    for scales in (12.0, 48.0):
        length = scales * s.scale
        t = np.arange(0.0, min(length, LONGEST * step), step)
        for period in (2.0 * s.scale, 8.0 * s.scale):
            turning = np.where(np.mod(t, period) < 0.5 * period, 1.0, -1.0)
            yield Manoeuvre(
                f"steps between ±{top:.3g} N m every {0.5 * period:.3g} s for {length:.0f} s", top * turning
            )
        hold = length / stairs.size
        yield Manoeuvre(
            f"stairs of 25, 50, 75 and 100 % of {top:.3g} N m both ways, with rests, {hold:.3g} s each",
            top * stairs[np.minimum((t / hold).astype(int), stairs.size - 1)],
        )
        sweep = 0.5 * t**2 / length * (1.95 / s.scale) + 0.05 / s.scale * t
        yield Manoeuvre(
            f"a sweep of {top:.3g} N m from {20.0 * s.scale:.3g} s to {0.5 * s.scale:.3g} s period in {length:.0f} s",
            top * np.sin(2.0 * np.pi * sweep),
        )


def _evidence(grid: Grid, model: TracedModel, found: Fit, alternative: Fit, manoeuvre: Manoeuvre) -> float:
    run = _driven(grid, model, manoeuvre)
    if float(np.max(np.abs(run.yaw_rate))) > 1.3 * float(np.max(np.abs(model.rate))):
        return 0.0  # beyond what was driven nothing is known of the damping
    driven = in_blocks([run], grid.signals.inertia, sorted(run.channels), grid.cell)
    driven = replace(driven, surprise=np.zeros((grid.surprise.shape[0], len(driven.signals))))
    missed, own = (_left(driven, each, found) for each in (alternative, found))
    return max(missed - 1.5 * own, 0.0)  # what its own model leaves is the error of integration


def _driven(grid: Grid, model: TracedModel, manoeuvre: Manoeuvre) -> Run:
    """The manoeuvre as the model drives it, the channels going up and down their range."""
    s, n = grid.signals, manoeuvre.torque.size
    time = np.asarray(s.origin[1] + grid.resolution * np.arange(n), dtype=np.float64)
    channels = {}
    for k, (name, values) in enumerate(sorted(s.channels.items())):
        low, high = (float(q) for q in np.quantile(values, [0.02, 0.98]))
        phase = 2.0 * np.pi * np.arange(n) / n * (1.37 + 0.61 * k)
        channels[name] = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(phase)
    still = np.zeros(n)
    start = Signals(
        step=grid.resolution, start=np.array([0, n], dtype=np.intp), time=time, rate=still, heading=still,
        torque=manoeuvre.torque, channels=channels,
    )  # fmt: skip
    index, rate = model.simulate(start, grid.resolution)
    return Run(manoeuvre.words, time[index], rate, manoeuvre.torque[index], {k: v[index] for k, v in channels.items()})


def _left(driven: Grid, fitted: Fit, noise: Fit) -> float:
    """Squared innovations, in those of the recordings' noise, that a fit leaves of a noiseless motion."""
    n = len(driven.signals)
    start = replace(fitted, noise=noise.noise, weight=np.ones(n), model=replace(fitted.model, loss=np.zeros(n)))
    again = fit(driven, fitted.parts, start, search=0)
    return float(np.sum(again.innovation**2)) / noise.sigma**2
