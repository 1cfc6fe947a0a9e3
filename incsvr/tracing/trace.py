"""From recordings to what the declared model lacks, and the proof on unseen data: the method in the order of its steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.signals.settings import TorqueKind
from incsvr.tracing.channels import usable
from incsvr.tracing.findings import Trace
from incsvr.tracing import innovations, windows
from incsvr.tracing.candidates import admissible, residual
from incsvr.tracing.cells import cut
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import fit
from incsvr.tracing.refusals import refuse_too_little_motion
from incsvr.tracing.result import result_of
from incsvr.tracing.search import Search
from incsvr.tracing.torque_nature import TorqueNature, answers, as_told
from incsvr.tracing.run import Run, check

__all__ = ["Run", "Trace", "trace"]


def trace(
    runs: Sequence[Run], *, inertia: float, validate: Sequence[Run] | None = None, torque: TorqueKind | None = None
) -> Trace:
    """Find what the declared model lacks.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.
        torque: whether the torque is what was commanded, or a measurement with noise of its own; None where nobody says.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    check(runs)
    if validate:
        check(validate)
    names, ignored = usable([*runs, *(validate or [])])
    try:
        problem, how = posed(runs, inertia, _read(runs, names), torque)
        other = cut(validate, inertia, [*problem.cells.signals.channels, *_heading(runs)], how) if validate else None
        search = Search.of(problem, admissible(names, problem.cells))
        nothing = search.tried(problem.start)
        refuse_too_little_motion(problem, nothing.fitted)
        return result_of(search, *search.run(), other, ignored)
    except np.linalg.LinAlgError as error:
        raise BadInput(
            f"the equations of these recordings have no solution ({error}): the vehicle hardly moves, or a channel "
            "repeats another; drive turns both ways with several torques, and leave out what is recorded twice"
        ) from error


def posed(runs: Sequence[Run], inertia: float, names: Sequence[str], torque: TorqueKind | None):  # type: ignore[no-untyped-def]
    """The predictions by which the recordings are judged: windows in open loop, innovations of commands in closed loop."""
    nature = as_told(runs, torque)
    problem = windows.pose(runs, inertia, names, nature)
    fitted = fit(problem, problem.start, problem.colour)
    cells = problem.cells
    closed = answers(residual(fitted.response.dynamics), cells.signals.torque, cells.start)
    if not closed or torque == "measured":
        return problem, windows.cutting(runs, inertia, nature)
    commands = TorqueNature(held=True, noisy=False, closed=True)
    return innovations.pose(runs, inertia, names, commands), innovations.cutting(runs, inertia, commands)


def _heading(runs: Sequence[Run]) -> list[str]:
    return ["heading"] * all("heading" in run.channels and np.isfinite(run.channels["heading"]).sum() > 5 for run in runs)


def _read(runs: Sequence[Run], names: Sequence[str]) -> list[str]:
    """The channels that are read: the candidates', and the heading where every run has one."""
    return [*names, *_heading(runs)]
