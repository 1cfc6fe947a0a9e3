"""The method, step by step: from recordings to the effects that the declared model lacks, and their proof."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.model_trace.channels import usable_channels
from incsvr.model_trace.findings import Trace
from incsvr.model_trace.run import Run, check
from incsvr.model_trace.thresholds import LOOP_CORRELATION, MIN_HEADING_SAMPLES, OTHER_GYRO_CORRELATION
from incsvr.model_trace.torque_nature import Loop, TorqueNature, answers, declared_nature, of_this_gyro, standing_time
from incsvr.signals.settings import MEASURED, TorqueKind
from incsvr.tracing import innovations, windows
from incsvr.tracing.candidates import admissible, residual
from incsvr.tracing.cells import Cut, cut
from incsvr.tracing.equivalence import simplest_equivalent
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, fit
from incsvr.tracing.free_run_relevance import without_unseen_effects
from incsvr.tracing.refusals import refuse_too_little_motion
from incsvr.tracing.result import result_of
from incsvr.tracing.search import Search


def trace(
    runs: Sequence[Run], *, inertia: float, validate: Sequence[Run] | None = None, torque: TorqueKind | None = None
) -> Trace:
    """Find what the declared model lacks.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.
        torque: whether the torque was commanded, or measured with noise of its own; None where nobody says.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    found = _traced(runs, inertia, validate, torque, must_find=False)
    assert found is not None
    return found


def trace_if_found(runs: Sequence[Run], *, inertia: float, torque: TorqueKind | None = None) -> Trace | None:
    """As `trace`; None where it finds no effect, without the work of proving that there is none."""
    return _traced(runs, inertia, None, torque, must_find=True)


def _traced(
    runs: Sequence[Run], inertia: float, validate: Sequence[Run] | None, torque: TorqueKind | None, must_find: bool
) -> Trace | None:
    check(runs)
    if validate:
        check(validate)
    names, ignored = usable_channels([*runs, *(validate or [])])
    headings = [run.channels.get("heading", np.empty(0)) for run in (*runs, *(validate or ()))]
    heading = ["heading"] * all(np.isfinite(values).sum() > MIN_HEADING_SAMPLES for values in headings)
    try:
        nature, loop = nature_of(runs, inertia, [*names, *heading], torque)
        problem, how = problem_of(runs, inertia, [*names, *heading], nature)
        search = Search.of(problem, admissible(names, problem.cells))
        refuse_too_little_motion(search)
        nothing, best = search.run()
        best = without_unseen_effects(search, simplest_equivalent(search, best))
        if loop is Loop.OTHER_GYRO and answer_left(problem, best.fitted) < OTHER_GYRO_CORRELATION:
            loop = Loop.OPEN  # what was missing had looked like an answer
        if loop is Loop.OTHER_GYRO:
            # such a torque tells of the rate beside the log, and what tells of the rate passes for effects
            search = Search.of(problem, ())
            best = search.tried(problem.start)
        if must_find and not best.names:
            return None
        other = cut(validate, inertia, [*problem.cells.signals.channels, *heading], how) if validate else None
        return result_of(search, nothing, best, other, ignored, loop)
    except np.linalg.LinAlgError as error:
        raise BadInput(
            f"the equations of these recordings have no solution ({error}): the vehicle hardly moves, or a channel "
            "repeats another; drive turns both ways with several torques, and leave out what is recorded twice"
        ) from error


def problem_of(runs: Sequence[Run], inertia: float, names: Sequence[str], nature: TorqueNature) -> tuple[Problem, Cut]:
    """The predictions by which the recordings are judged: windows, or innovations of commands that answer the rate."""
    form = innovations if nature.closed else windows
    return form.pose(runs, inertia, names, nature), form.cutting(runs, inertia, nature)


def nature_of(
    runs: Sequence[Run], inertia: float, names: Sequence[str], torque: TorqueKind | None
) -> tuple[TorqueNature, Loop]:
    """The kind of torque, and its relation to the rate."""
    nature = declared_nature(runs, torque)
    problem, how = problem_of(runs, inertia, names, nature)
    if standing_time(runs) > how.steps * how.step:
        return nature, Loop.OPEN
    fitted = fit(problem, problem.start, problem.colour)
    answer = answer_left(problem, fitted)
    if answer < LOOP_CORRELATION:
        return nature, Loop.OPEN
    if torque == MEASURED:
        return nature, Loop.CLOSED
    if of_this_gyro(runs):
        return TorqueNature(held=True, noisy=False, closed=True), Loop.CLOSED
    return nature, Loop.OTHER_GYRO if answer > OTHER_GYRO_CORRELATION else Loop.OPEN


def answer_left(problem: Problem, fitted: Fit) -> float:
    """The correlation of the torque with a fit's residual."""
    cells = problem.cells
    return answers(residual(fitted.response.dynamics), cells.signals.torque, cells.start)
