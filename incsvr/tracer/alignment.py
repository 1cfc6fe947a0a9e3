"""How the torque runs between its stamps: held, as a command is, or linear, as a measured moment."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.effects.effect import FROM_COMMAND, FROM_RATE
from incsvr.effects.torque_delay import TorqueDelay
from incsvr.tracer.hypothesis import nothing
from incsvr.tracer.problem import Problem, pose
from incsvr.tracer.run import Run
from incsvr.tracer.search import THRESHOLD, scan, with_lead


def aligned(runs: Sequence[Run], inertia: float, channels: Sequence[str]) -> Problem:
    """The equations with the linear torque, unless holding it has the evidence that any effect must bring.

    Both are given a free delay before they are compared: holding delays by half a sample, and would else be taken for a
    late thrust. On one sine the two differ by chance alone, and half a sample of false delay looks like an effect.
    """
    linear = pose(runs, inertia, channels, held=False)
    if linear.resolution <= linear.blocks.period / 10.0:
        return linear
    held = pose(runs, inertia, channels, held=True)
    gain = (_explained(held) - _explained(linear)) * len(linear.blocks)
    return held if gain > THRESHOLD else linear


def _explained(problem: Problem) -> float:
    base = nothing(problem)
    delays = [TorqueDelay(FROM_RATE), TorqueDelay(FROM_COMMAND)]
    late = max((with_lead(problem, base, lead).criterion for lead in scan(problem, base, delays)), default=0.0)
    return max(base.criterion, late) / len(problem.blocks)
