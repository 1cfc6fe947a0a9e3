"""Whether an effect hangs on how often the torque was sampled: with every second sample of it, it must be the same.

Between its samples nobody knows the torque. What a fast controller did there is missing in the equations, follows the
motion, and passes for an effect of the motion; of half the samples two to four times as much is missing, while a true
effect stays as large as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.evidence import NORMAL_95, intervals
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle
from incsvr.tracer.posing import pose
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Run

HANGS, EDGE = 0.3, 0.15
"""Part of its size by which an effect may change with half the samples, and of where a dead band or a limit lies: true
effects of 22 fast loops changed by 0.21, and where they lie by 0.06, at most."""

SURELY = 3.0
"""Standard errors that the change must be."""


def hangs(problem: Problem, found: Hypothesis, runs: Sequence[Run], channels: Sequence[str]) -> tuple[int, str] | None:
    """Which effect changes the most with every second sample of the torque, and why it is not believed; else None."""
    half = _half(problem, runs, channels)
    refine = frozenset(e.key for e in found.effects if e.searched and not e.needs_clock)
    again = settle(half, found.values(), nothing(half), refine, passes=8)
    spans, others = intervals(problem, found), intervals(half, again)
    worst: tuple[float, int, str] = (1.0, -1, "")
    for k, (effect, term, other) in enumerate(zip(found.effects, found.terms, again.terms, strict=True)):
        # when a command of levels jumped, of half the samples nobody knows: no delay or lag is as it was
        if not effect.of_phase or (effect.acts == "thrust" and effect.lingers):
            continue
        old, new = (x.inner[-1] if effect.whole else x.coefficients[0] for x in (term, other))
        change = abs(new / old - 1.0) / (EDGE if effect.whole else HANGS)
        name, (low, high) = next(iter(spans[k].items()))
        first, last = others[k][name]
        doubt = float(np.hypot(high - low, last - first)) / (2.0 * NORMAL_95)
        here, there = 0.5 * (low + high), 0.5 * (first + last)
        if abs(here - there) > SURELY * doubt:
            worst = max(worst, (change, k, f"its {name} is {here:.3g}, and {there:.3g} with every second sample"))
    _, k, sizes = worst
    return (k, f"it hangs on how often the torque was sampled: {sizes}") if sizes else None


def _half(problem: Problem, runs: Sequence[Run], channels: Sequence[str]) -> Problem:
    """The equations of the same blocks with every second sample of the torque, the noise read as it was with all."""
    s = problem.signals
    half = pose([_thinned(run) for run in runs], s.inertia, channels, held=problem.held, period=problem.blocks.period)
    known = s.known and half.command.plain is not None
    signals = replace(half.signals, share=s.share, gyro=s.gyro, known=known)
    return replace(half, signals=signals, feedback=problem.feedback).answering(problem.drag, problem.colour)


def _thinned(run: Run) -> Run:
    torque = run.torque.copy()
    torque[np.flatnonzero(np.isfinite(torque))[1::2]] = np.nan
    return replace(run, torque=torque)
