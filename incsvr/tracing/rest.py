"""What a predictor still lacks as a curve of a stream: no effect has that shape, so it is called unexplained."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model.candidates import Candidate
from incsvr.model.directions import directions
from incsvr.model.fitting import Fit, fit
from incsvr.model.rows import ONE, Factor, Row, row
from incsvr.model.search import convincing
from incsvr.model.series import values
from incsvr.tracing.findings import UnexplainedChannel
from incsvr.tracing.statistics import p_value


def smooth_rest(
    predictor: Fit,
    channels: Sequence[str],
    most: int = 3,  # a reader follows no more
) -> tuple[Fit, tuple[UnexplainedChannel, ...]]:
    """The predictor with curves of what still predicts its errors, and the names of these streams.

    Args:
        channels: streams that may do so, beside the velocity itself.
    """
    (axis,) = predictor.structure.axes
    names, found = [axis, *channels], list[UnexplainedChannel]()
    while len(found) < most:
        left = [name for name in names if name not in {each.channel for each in found}]
        every = [candidate for name in left if (candidate := _curve(predictor, name)) is not None]
        weighed = directions(predictor, every)
        sound = convincing((each, weighed.evidence(k)) for k, each in enumerate(every))
        if not sound:
            break
        evidence, best = max(sound, key=lambda one: one[0].excluded.total)
        predictor = fit(best.structure, {**predictor.theta, **best.start}, predictor.problem, predictor.starts)
        found.append(UnexplainedChannel(best.name, p_value(2.0 * evidence.gain, len(best.start), len(names))))
    return predictor, tuple(found)


def _curve(predictor: Fit, name: str) -> Candidate | None:
    """A moment that is a cubic curve of a stream, of the heading two harmonics, of the own velocity its size."""
    structure = predictor.structure
    (axis,) = structure.axes
    if name == axis:
        pairs = [(Factor("size", name), ONE)]
    elif name == "heading":
        pairs = [(Factor(kind, name), ONE) for kind in ("sine", "cosine", "sine2", "cosine2")]
    else:
        about = Factor("about", name, float(np.mean(values(predictor.problem.windows.runs, name))))
        pairs = [(about, ONE), (about, about), (about, Factor("square", name))]
    own = {each.key for each in structure.rows}
    rows: list[Row] = [row(f"unexplained:{name}:{k}", axis, *pair) for k, pair in enumerate(pairs)]
    rows += [each for each in (row("bias_torque", axis, ONE),) if each.key not in own]
    if own & {each.key for each in rows}:
        return None
    return Candidate(name, structure.plus(rows=rows), dict.fromkeys((each.key for each in rows), 0.0), tuple(rows))
