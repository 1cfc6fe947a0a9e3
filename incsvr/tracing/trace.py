"""From recordings to what the declared model lacks: which way answers, and the answer.

Where the torque is a command and a controller closed the loop, the forward form leads: there it alone is free of the
bias that a torque brings which answers the water. Elsewhere the weak form proposes, which allows for noise in a
measured torque, and in open loop the free run proves; of a command's effects that it does not prove, those stay that
pay in the forward form.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.signals.settings import COMMANDED, TorqueKind
from incsvr.tracing.channels import usable
from incsvr.tracing.findings import Trace
from incsvr.tracing.forward.equations import Part
from incsvr.tracing.forward.fit import Fit, fit
from incsvr.tracing.forward.forward_trace import forward_trace, read
from incsvr.tracing.forward.grid import Grid, cells
from incsvr.tracing.forward.loop import loop_of
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.refusals import refuse_opposite_signs, refuse_too_little_motion
from incsvr.tracing.forward.search import gain_of
from incsvr.tracing.forward.thresholds import REQUIRED_GAIN
from incsvr.tracing.output_error import identified
from incsvr.tracing.run import Run, check
from incsvr.tracing.weak.redeclared import traced_anew
from incsvr.tracing.weak.weak_trace import weak_trace

__all__ = ["Run", "Trace", "trace"]


def trace(
    runs: Sequence[Run], *, inertia: float, validate: Sequence[Run] | None = None, torque: TorqueKind | None = None
) -> Trace:
    """Find what the declared model lacks.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.
        torque: whether the torque is what was commanded, or a measurement with noise of its own; told from the data
            where it is not given.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    check(runs)
    if validate:
        check(validate)
    try:
        return _trace(runs, inertia, validate, torque)
    except np.linalg.LinAlgError as error:
        raise BadInput(
            f"the equations of these recordings have no solution ({error}): the vehicle hardly moves, or a channel "
            "repeats another; drive turns both ways with several torques, and leave out what is recorded twice"
        ) from error


def _trace(runs: Sequence[Run], inertia: float, validate: Sequence[Run] | None, torque: TorqueKind | None) -> Trace:
    names, ignored = usable([*runs, *(validate or [])])
    grid = cells(runs, inertia, read(runs, names))
    base = fit(grid)
    refuse_too_little_motion(grid, base)
    loop = loop_of(grid, base)
    commanded = loop.commanded if torque is None else torque == COMMANDED
    if commanded and loop.closed:
        refuse_opposite_signs(grid)
        return forward_trace(runs, inertia, validate, names, ignored)
    holds = None if torque is None else torque == COMMANDED
    shown = identified(grid.signals)
    if shown is not None and shown.contradicts(inertia):
        return traced_anew(runs, inertia, shown, validate, names, ignored, {}, holds)
    found = weak_trace(runs, inertia, validate, names, ignored, {}, holds)
    if commanded and not found.proven:
        unsupported = _unsupported(grid, base, found)
        if unsupported:
            return weak_trace(runs, inertia, validate, names, ignored, unsupported, holds)
    return found


def _unsupported(grid: Grid, base: Fit, found: Trace) -> dict[str, str]:
    """The effects that no free run proves and that do not pay in the forward form either, and why."""
    parts = [Part(*pair) for pair in zip(found.model.effects(), found.model.terms, strict=True)]
    question = Question.of(grid, [part.effect for part in parts], base)
    parts = [part for part in parts if part.effect.key in question.prices]
    fitted = fit(grid, parts, base)
    gains = {part.name: gain_of(question, fitted, k) for k, part in enumerate(parts)}
    return {
        name: f"predicting each rise of the rate from what is known before it, it brings {gain:.3g} of the "
        f"{REQUIRED_GAIN:g} that are asked, and no free run proves it"
        for name, gain in gains.items()
        if gain < REQUIRED_GAIN
    }
