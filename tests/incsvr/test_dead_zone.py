"""A dead band whose edge is a step, under a controller that keeps its command there."""

from __future__ import annotations

import pytest

from incsvr.effects import catalogue
from incsvr.tracer.alignment import aligned
from incsvr.tracer.hypothesis import nothing, settle
from incsvr.tracer.run import Run
from simulator.trial import Trial, play


def test_a_steps_edge_is_found_from_the_starts_beside_it() -> None:
    """A sixth beside it next to nothing is explained: a search from starts further apart would pass it."""
    outcome = play(Trial(190_104, ("dead_zone",), vehicle="small", excitation="closed_loop", autocorrelation=0.9))
    columns, truth = outcome.recording.columns, outcome.truth["dead_zone"]
    assert truth["shape"] == "jump"
    width = float(truth["half_width_nm"])
    problem = aligned([Run("loop", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})],
                      outcome.inertia, [])  # fmt: skip
    base, step = nothing(problem), catalogue()["dead_zone/step"]
    starts = sorted(step.starts(problem.signals), key=lambda start: abs(start[-1] - width))[:2]
    tried = [settle(problem, [(step, start, ())], base, frozenset({step.key})) for start in starts]
    found = max(tried, key=lambda hypothesis: hypothesis.criterion)
    assert found.terms[0].inner[-1] == pytest.approx(width, rel=0.03)
    assert found.criterion > base.criterion + 400.0
    beside = settle(problem, [(step, (1.17 * width,), ())], base)
    assert beside.criterion < base.criterion + 40.0
